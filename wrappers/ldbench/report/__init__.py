"""Reports on several runs: the submission, comparisons and studies."""
