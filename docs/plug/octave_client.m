% The wheelset of a namelist by Octave's ode45 on the contact force of libldbench, which ldbench_octave.c makes known to Octave.
%
% usage: octave octave_client.m ex1_aw.nml 0.25
% Prints the times at which the wheelset passes the centre [s].
words = argv();
f = num2cell(ldbench_octave(words{1}));
[case_number, mass, inertia, weight] = f{1:4};
start = [f{5:10}];

rates = @(t, x) [x(4:6); (ldbench_octave(case_number, x(1:3)) - [0; weight; 0])./[mass; mass; inertia]];
[t, x] = ode45(rates, [0, str2double(words{2})], start, odeset("RelTol", 1e-10, "AbsTol", 1e-12, "MaxStep", 1e-4));
t = t(:);
k = find(x(1:end-1, 1).*x(2:end, 1) < 0);
h = t(k+1) - t(k);
printf("%.9f ", t(k) - x(k, 1).*h./(x(k+1, 1) - x(k, 1)));
printf("\n");
