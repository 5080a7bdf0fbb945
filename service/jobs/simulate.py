#!/usr/bin/env python3
"""What many thumbnails cost: a simulation of queue, cache, shards, stragglers and deaths, from measured times (measured.tsv).

The same numbers whenever it runs: every table has a seed of its own. Up to a million models each one is drawn from the measured
distribution; above, shards are sums: normally distributed but for the slowest hundredth, whose models are drawn one by one.

Run:  simulate.py [TABLE ...]     prints tables (all of them by default)
      simulate.py --check PAGE    ends with 1 if the page's tables are not these
      simulate.py --update PAGE   writes them into the page
"""
import argparse
import bisect
import heapq
import math
import pathlib
import random
import re
import sys

# Assumptions; the page has them in a table.
START = 20.0  # seconds from the order of a machine to the first model: image, process, environment
DEADLINE = 60.0  # --deadline
TAIL = 0.01  # what is drawn one by one: the slowest hundredth
BEYOND = 0.001  # models slower than any measured one: Pareto from there
PARETO = 1.2
HANG = 0.0001  # models that end at the deadline
DEATHS = 0.05  # of a worker, an hour
CPU_HOUR, STORED_GB, SENT_GB, PUT, GET = 0.04, 0.023, 0.09, 0.005 / 1000, 0.0004 / 1000  # dollars


class Distribution:
    """Quantiles, linear between them."""

    def __init__(self, percents, values):
        self.at = [percent / 100 for percent in percents]
        self.values = values

    def quantile(self, part):
        k = min(max(bisect.bisect_right(self.at, part) - 1, 0), len(self.at) - 2)
        low, high = self.at[k], self.at[k + 1]
        return self.values[k] + (self.values[k + 1] - self.values[k]) * (part - low) / (high - low)

    def moments(self, end=1.0):
        """Mean and variance of what is below a quantile."""
        mean = square = 0.0
        for low, high, a, b in zip(self.at, self.at[1:], self.values, self.values[1:]):
            if high <= end:
                mean += (high - low) * (a + b) / 2
                square += (high - low) * (a * a + a * b + b * b) / 3
        mean, square = mean / end, square / end
        return mean, square - mean * mean


def measured():
    rows = [line.split("\t") for line in (pathlib.Path(__file__).parent / "measured.tsv").read_text().splitlines()
            if not line.startswith("#")]
    columns = list(zip(*rows[1:]))
    percents = [float(value) for value in columns[0]]
    return {name: Distribution(percents, [float(value) for value in column])
            for name, column in zip(rows[0][1:], columns[1:])}


MEASURED = measured()


class Times:
    """Processor seconds of models: the measured ones, and what a larger collection has beyond them."""

    def __init__(self, seed, size=256, beyond=BEYOND, hang=HANG, deadline=DEADLINE):
        self.dice = random.Random(seed)
        self.measured = MEASURED[f"seconds_{size}"]
        self.beyond, self.hang, self.deadline = beyond, hang, deadline
        self.body = self.measured.moments(1 - TAIL)

    def tail(self):
        u = self.dice.random() * TAIL
        if u < self.hang:
            return self.deadline
        if u < self.hang + self.beyond:
            part = (u - self.hang) / self.beyond
            return min(self.measured.values[-1] * (1 - part) ** (-1 / PARETO), self.deadline)
        return self.measured.quantile(1 - TAIL + TAIL * self.dice.random())

    def one(self):
        u = self.dice.random()
        return self.tail() if u < TAIL else self.measured.quantile(u - TAIL)

    def sum(self, count):
        """Seconds of so many models."""
        if count <= 100:
            return sum(self.one() for _ in range(count))
        slow = self.about(count * TAIL)
        mean, variance = self.body
        rest = max(count - slow, 0)
        body = max(rest * mean + math.sqrt(rest * variance) * self.normal(), 0.0)
        if slow <= 20_000:
            return body + sum(self.tail() for _ in range(slow))
        # Of so many the mean of a sample is known well enough.
        return body + slow * sum(self.tail() for _ in range(20_000)) / 20_000

    def about(self, mean):
        """A number of rare events."""
        if mean > 100:
            return max(round(mean + math.sqrt(mean) * self.normal()), 0)
        count, product = 0, self.dice.random()
        while product > math.exp(-mean):
            count, product = count + 1, product * self.dice.random()
        return count

    def normal(self):
        return math.sqrt(-2 * math.log(1 - self.dice.random())) * math.cos(2 * math.pi * self.dice.random())

    def exponential(self, mean):
        return -mean * math.log(1 - self.dice.random())


def run_shards(works, workers, times, deaths=DEATHS, resume=True, start=START):
    """Shards in their order to whoever is free. Hours until the last is done, of work, lost to deaths, of starts, of waiting at the end.

    A dead worker's shard is begun again by the next one: from where it was with `resume` (one model and a start are lost), else
    from its beginning."""
    free = [0.0] * min(workers, len(works))
    heapq.heapify(free)
    worked = lost = starts = 0.0
    for work in works:
        begun = heapq.heappop(free)
        now, left = begun, work
        while True:
            dies = times.exponential(3600 / deaths) if deaths else math.inf
            starts += min(start, dies)
            if dies >= start + left:
                now += start + left
                break
            now += dies
            done = max(dies - start, 0.0)
            if resume:
                # On average half of a model was done in vain.
                kept = max(done - times.one() / 2, 0.0)
                lost += done - kept
                left -= kept
            else:
                lost += done
        worked += work
        heapq.heappush(free, now)
    end = max(free)
    idle = sum(end - at for at in free)
    return [value / 3600 for value in (end, worked, lost, starts, idle)]


def count(n):
    return f"10^{round(math.log10(n))}"


def number(v):
    """Three digits."""
    if v == 0:
        return "0"
    digits = max(2 - math.floor(math.log10(abs(v)) + 1e-9), 0)
    return f"{v:,.{digits}f}" if v < 1e6 else f"{float(f'{v:.3g}'):,.0f}"


def percent(v):
    return f"{100 * v:.1f} %"


def table_measured():
    rows = [["", "mean", "median", "90 %", "99 %", "largest"]]
    for name, label, unit, digits in [
            ("seconds_256", "processor seconds, 256 x 256", 1, 3), ("seconds_512", "processor seconds, 512 x 512", 1, 3),
            ("picture_bytes_256", "PNG in KB, 256 x 256", 1000, 0), ("picture_bytes_512", "PNG in KB, 512 x 512", 1000, 0),
            ("model_bytes", "model with its files in KB", 1000, 0)]:
        of = MEASURED[name]
        values = [of.moments()[0], *(of.quantile(q) for q in (0.5, 0.9, 0.99, 1.0))]
        rows.append([label, *(f"{v / unit:,.{digits}f}" for v in values)])
    return rows


def table_totals():
    rows = [["models", "size", "processor hours", "GB read", "GB written", "processors", "requests", "storage a month", "all of that",
             "sent out once"]]
    for exponent in (4, 5, 6, 7, 8, 9):
        n = 10 ** exponent
        for size in (256, 512):
            times = Times(exponent * 1000 + size, size)
            hours = (sum(times.one() for _ in range(n)) if n <= 10 ** 6 else times.sum(n)) / 3600
            read = n * MEASURED["model_bytes"].moments()[0] / 1e9
            written = n * MEASURED[f"picture_bytes_{size}"].moments()[0] / 1e9
            cpu, asked, stored = hours * CPU_HOUR, n * (PUT + GET), written * STORED_GB
            rows.append([count(n), str(size), number(hours), number(read), number(written),
                         *(f"${number(v)}" for v in (cpu, asked, stored, cpu + asked + stored, written * SENT_GB))])
    return rows


def table_shards():
    rows = [["models", "workers", "shard", "shards", "hours until the last", "starts", "lost to deaths", "waiting at the end", "of processors at work"]]
    cases = [(10 ** 6, 100, (10, 100, 1000, 10_000)), (10 ** 6, 10, (1000, 10_000, 100_000)),
             (10 ** 9, 1000, (10_000, 100_000, 1_000_000))]
    for n, workers, sizes in cases:
        times = Times(17)
        if n <= 10 ** 6:
            models = [times.one() for _ in range(n)]
        for size in sizes:
            if n <= 10 ** 6:
                works = [sum(models[k:k + size]) for k in range(0, n, size)]
            else:
                works = [times.sum(size) for _ in range(n // size)]
            end, worked, lost, starts, idle = run_shards(works, workers, times)
            all_hours = worked + lost + starts + idle
            rows.append([count(n), str(workers), f"{size:,}", f"{len(works):,}", number(end), percent(starts / all_hours),
                         percent(lost / all_hours), percent(idle / all_hours), percent(worked / all_hours)])
    return rows


def table_stragglers():
    rows = [["tail", "deadline", "mean seconds a model", "of it by the slowest hundredth", "hours until the last", "of processors at work"]]
    for label, beyond, hang in (("as measured", 0.0, 0.0), ("assumed", BEYOND, HANG), ("five times as many", 5 * BEYOND, 5 * HANG)):
        for deadline in (60.0, 600.0):
            if not beyond and deadline > 60:
                continue
            times = Times(23, beyond=beyond, hang=hang, deadline=deadline)
            models = [times.one() for _ in range(10 ** 6)]
            works = [sum(models[k:k + 1000]) for k in range(0, len(models), 1000)]
            end, worked, lost, starts, idle = run_shards(works, 100, times, deaths=0)
            slow = sum(sorted(models)[-len(models) // 100:])
            rows.append([label, f"{deadline:.0f} s", f"{sum(models) / len(models):.3f}", percent(slow / sum(models)), number(end),
                         percent(worked / (worked + lost + starts + idle))])
    return rows


def table_deaths():
    rows = [["deaths of a worker an hour", "shard", "hours with --resume", "lost", "hours without", "lost"]]
    for deaths in (0.0, 0.05, 0.5, 5.0):
        for size in (1000, 10_000):
            cells = []
            for resume in (True, False):
                times = Times(29)
                works = [times.sum(size) for _ in range(10 ** 6 // size)]
                end, worked, lost, starts, idle = run_shards(works, 100, times, deaths, resume)
                plain = START * len(works) / 3600
                cells += [number(end), percent((lost + max(starts - plain, 0.0)) / worked)]
            rows.append([str(deaths), f"{size:,}", *cells])
    return rows


def hit_rate(models, cached, exponent):
    """Of the pictures last asked for (LRU) where the k-th most wanted model is asked for in proportion to k^-exponent (Che's approximation).

    Ranks beyond the first thousand are taken together in steps of a hundredth."""
    ranks, k = [], 1.0
    while k <= models:
        step = 1.0 if k < 1000 else k / 100
        step = min(step, models - k + 1)
        ranks.append(((k + (step - 1) / 2) ** -exponent, step))
        k += step
    total = sum(weight * many for weight, many in ranks)
    low, high = 0.0, 1e6 * models
    for _ in range(200):
        middle = (low + high) / 2
        full = sum(many * -math.expm1(-weight / total * middle) for weight, many in ranks)
        low, high = (middle, high) if full < cached else (low, middle)
    return sum(many * weight / total * -math.expm1(-weight / total * low) for weight, many in ranks)


def table_cache():
    rows = [["models", "requests", "cache holds", "GB of cache", "popularity", "hits", "processor hours saved", "worth", "cache a month"]]
    times = Times(31)
    mean = sum(times.one() for _ in range(10 ** 6)) / 10 ** 6
    for models in (10 ** 6, 10 ** 9):
        requests = 10 * models
        for part in (0.001, 0.01, 0.1):
            for exponent in (0.7, 1.0):
                cached = part * models
                hits = hit_rate(models, cached, exponent)
                saved = hits * requests * mean / 3600
                gigabytes = cached * MEASURED["picture_bytes_256"].moments()[0] / 1e9
                rows.append([count(models), count(requests), percent(part), number(gigabytes), f"k^-{exponent}", percent(hits), number(saved),
                             f"${number(saved * CPU_HOUR)}", f"${number(gigabytes * STORED_GB)}"])
    return rows


def queue(load, workers, places, requests, seed, deadline):
    """Seconds until each request is answered, and the part that is refused: arrivals by chance, one queue of bounded length."""
    times = Times(seed, deadline=deadline)
    mean = times.body[0] * (1 - TAIL) + TAIL * sum(times.tail() for _ in range(100_000)) / 100_000
    gap = mean / (load * workers)
    free = [0.0] * workers
    waiting = []  # when those that wait begin
    now, taken, refused = 0.0, [], 0
    for _ in range(requests):
        now += times.exponential(gap)
        while waiting and waiting[0] <= now:
            heapq.heappop(waiting)
        if len(waiting) >= places:
            refused += 1
            continue
        begins = max(heapq.heappop(free), now)
        if begins > now:
            heapq.heappush(waiting, begins)
        ends = begins + times.one()
        heapq.heappush(free, ends)
        taken.append(ends - now)
    taken.sort()
    return taken, refused / requests


def table_queue():
    rows = [["workers", "deadline", "load", "median", "99 %", "99.9 %", "refused (429)"]]
    for workers in (2, 16):
        for deadline in (60.0, 5.0):
            for load in (0.5, 0.7, 0.9, 1.2):
                taken, refused = queue(load, workers, 8 * workers, 200_000, 37, deadline)
                at = (taken[int(len(taken) * part)] for part in (0.5, 0.99, 0.999))
                rows.append([str(workers), f"{deadline:.0f} s", percent(load), *(f"{v:.2f} s" for v in at), percent(refused)])
    return rows


TABLES = {name[6:]: make for name, make in list(globals().items()) if name.startswith("table_")}


def markdown(rows):
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines).replace("|  |", "| |")


# A command in a block of its own, and the table below it.
PLACE = re.compile(r"(```sh\npython3 service/jobs/simulate\.py (\w+)\n```\n\n)((?:\|.*\n)+)")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(TABLES))
    page = arguments.add_mutually_exclusive_group()
    page.add_argument("--check", type=pathlib.Path, metavar="PAGE")
    page.add_argument("--update", type=pathlib.Path, metavar="PAGE")
    args = arguments.parse_args()
    unknown = [name for name in args.tables if name not in TABLES]
    if unknown:
        arguments.error(f"no table {unknown[0]}; there are {', '.join(TABLES)}")
    made = {name: markdown(TABLES[name]()) for name in args.tables or TABLES}
    path = args.check or args.update
    if not path:
        print("\n\n".join(made.values()))
        return
    before = path.read_text()
    named = [found[1] for found in PLACE.findall(before)]
    after = PLACE.sub(lambda found: found[1] + made.get(found[2], "") + "\n", before)
    if args.update:
        path.write_text(after)
    if sorted(named) != sorted(made):
        sys.exit(f"{path}: tables {', '.join(named)} in place of {', '.join(made)}")
    if args.check and after != before:
        wrong = [line for line, right in zip(before.splitlines(), after.splitlines()) if line != right]
        sys.exit(f"{path}: not what the simulation prints: {wrong[0] if wrong else 'too few or too many rows'}")


if __name__ == "__main__":
    main()
