"""What a scheduler and a client do for many workers: their cost of a task, measured, and a simulation with it."""
from __future__ import annotations

import heapq
import itertools
import pickle
import time
from dataclasses import dataclass

import distributed
import numpy as np
import psutil

from ldbench.ensembles.cluster import AHEAD, Left, Pieces
from ldbench.ensembles.members import Group
from local_cluster import Cluster

TASKS = 400
MEMBERS = 100                       # of a task that brings records
FIGURES, OCCURRENCES = 90, 100      # of a record: single numbers, and times and forces of events


@dataclass(frozen=True)
class Costs:
    """Processor time [s] of a task and, besides, of each member's record in it."""

    scheduler: float
    scheduler_record: float
    client: float
    client_record: float


@dataclass(frozen=True)
class Outcome:
    """What a simulated sweep took."""

    busy: float             # share of the workers' time in which they run members
    rate: float             # tasks per second
    scheduler: float        # shares of the time in which they work
    client: float


def measured_costs(cluster: Cluster) -> Costs:
    """From tasks without and with records, as many under way as in a sweep."""
    scheduler = psutil.Process(cluster.processes[0].pid)

    def bring(number: int, members: int, figures: int = FIGURES, occurrences: int = OCCURRENCES) -> bytes:
        """A task that brings so many records. Its text goes to the workers, which know nothing of this file."""
        import pickle

        import numpy as np

        batch = {str(k): np.random.default_rng(k).random(members) for k in range(figures)}
        return pickle.dumps((batch | {"events": np.zeros((members, occurrences))}, 1.0))

    def spent() -> np.ndarray:
        times = scheduler.cpu_times()
        return np.array([times.user + times.system, time.process_time()])

    with distributed.Client(cluster.address, set_as_default=False) as client:
        def through(tasks: int, members: int) -> np.ndarray:
            begin = spent()
            done = distributed.as_completed(loop=client.loop, with_results=True)
            sent = back = 0
            while back < tasks:
                n = min(tasks - sent, AHEAD*(len(cluster.processes) - 1) - (sent - back))
                if n > 0:
                    done.update(client.map(bring, range(sent, sent + n), members=members, pure=False))
                    sent += n
                for _, pickled in done.next_batch():
                    pickle.loads(pickled)
                    back += 1
            return (spent() - begin)/tasks

        through(8, 1)
        plain, loaded = through(TASKS, 0), through(TASKS, MEMBERS)
    records = np.maximum(loaded - plain, 0)/MEMBERS
    return Costs(plain[0], records[0], plain[1], records[1])


class Server:
    """Does one thing at a time, in the order in which they come."""

    def __init__(self) -> None:
        self.free = self.busy = 0.0

    def serve(self, now: float, cost: float) -> float:
        """When it is done."""
        self.busy += cost
        self.free = max(self.free, now) + cost
        return self.free


def simulate(threads: int, seconds: float, members: int, costs: Costs) -> Outcome:
    """A sweep of members that take so many seconds each, in the pieces that are sent.

    Half of a task's cost comes when it goes, half and its records' when it is done. A thread takes a task as soon as it
    is there.
    """
    pieces = Pieces([Group(None, range(members))])
    client, scheduler, free = Server(), Server(), [0.0]*threads      # threads: when they are
    order, under_way = itertools.count(), 0
    events: list[tuple[float, int, str, Left, int]] = []

    def send(now: float) -> None:
        nonlocal under_way
        while under_way < AHEAD*threads and (piece := pieces.next(threads)):
            under_way += 1
            then = client.serve(now, costs.client/2)
            heapq.heappush(events, (then, next(order), "sent", piece[0], len(piece[1])))

    send(0.0)
    while events:
        now, number, what, own, size = heapq.heappop(events)
        if what == "sent":
            then, follows = scheduler.serve(now, costs.scheduler/2), "there"
        elif what == "there":
            then, follows = max(now, heapq.heappop(free)) + size*seconds, "done"
            heapq.heappush(free, then)
        elif what == "done":
            then, follows = scheduler.serve(now, costs.scheduler/2 + size*costs.scheduler_record), "back"
        else:
            then = client.serve(now, costs.client/2 + size*costs.client_record)
            under_way -= 1
            own.add(size, size*seconds)
            send(then)
            continue
        heapq.heappush(events, (then, number, follows, own, size))
    end = client.free
    return Outcome(members*seconds/(threads*end), next(order)/end, scheduler.busy/end, client.busy/end)
