"""Tables of the comparison of environments."""

import math
import statistics

#: 97.5 % quantiles of Student's t by degrees of freedom.
STUDENT = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262}
TITLES = {"lengths": "paper’s robot, lengths", "tensions": "no spine, no damping; tensions", "own": "robots of its own"}


def digits(value, count=3):
    """So many significant digits, without an exponent."""
    if not math.isfinite(value) or value == 0:
        return "–"
    places = max(count - 1 - math.floor(math.log10(abs(value))), 0)
    return f"{value:,.{places}f}"


def of(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def mean(rows, key):
    found = [row[key] for row in rows if math.isfinite(row[key])]
    return math.exp(statistics.fmean(map(math.log, found))) if found else math.nan


def ratio(upper, lower, key="cpu_s_per_step"):
    """Geometric mean of the ratio within rounds, and its 95 % interval."""
    pairs = [(a[key], b[key]) for a in upper for b in lower if a["round"] == b["round"]]
    logs = [math.log(a / b) for a, b in pairs if a > 0 and b > 0]
    if not logs:
        return None
    middle = statistics.fmean(logs)
    if len(logs) < 2:
        return math.exp(middle), None
    half = STUDENT.get(len(logs) - 1, 1.96) * statistics.stdev(logs) / math.sqrt(len(logs))
    return math.exp(middle), (math.exp(middle - half), math.exp(middle + half))


def with_interval(found):
    if found is None:
        return "–"
    value, interval = found
    return digits(value) + (f" ({digits(interval[0])}–{digits(interval[1])})" if interval else "")


def settings(rows):
    seen = []
    for row in rows:
        key = (row["task"], row["peer"], row["setting"])
        if row["task"] in TITLES and key not in seen:
            seen.append(key)
    order = list(TITLES)
    return sorted(seen, key=lambda key: (order.index(key[0]), key[1] != "spinebench"))


def speeds(rows, wanted_mm):
    """Steps and simulated time of every setting on one core, and on two side by side."""
    lines = [
        "| Robot | Environment | Setting | tip off by | steps/s, one core | two side by side | simulated s per CPU-s | CPU time over ours |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    before = ("", "")
    for task, peer, setting in settings(rows):
        own = of(rows, task=task, peer=peer, setting=setting, processes=1)
        pair = of(rows, task=task, peer=peer, setting=setting, processes=2)
        names = [TITLES[task] if task != before[0] else "", peer if (task, peer) != before else ""]
        before = (task, peer)
        failed = next((row["status"] for row in own if row["status"] != "ok"), None)
        if failed:
            lines.append(f"| {' | '.join(names)} | {setting} | {failed} | – | – | – | – |")
            continue
        error_mm = 1e3 * mean(own, "rms_error_m")
        ours = fastest_within(rows, task, "spinebench", wanted_mm)
        is_ours = bool(ours) and ours[0]["setting"] == setting and peer == "spinebench"
        cells = [
            *names, setting, f"{digits(error_mm)} mm" if math.isfinite(error_mm) else "–",
            digits(1 / mean(own, "cpu_s_per_step")), digits(2 / mean(pair, "cpu_s_per_step")) if pair else "–",
            digits(mean(own, "simulated_s_per_cpu_s")), "**1**" if is_ours else with_interval(ratio(own, ours)),
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def fastest_within(rows, task, peer, most_mm):
    """Rows of the fastest setting of a peer within an error."""
    keys = [key for key in settings(rows) if key[:2] == (task, peer)]
    found = [of(rows, task=task, peer=peer, setting=key[2], processes=1) for key in keys]
    found = [own for own in found if own and 1e3 * mean(own, "rms_error_m") <= most_mm]
    return min(found, key=lambda own: mean(own, "cpu_s_per_step"), default=[])


def verdict(found, wanted, below=False):
    """Reached or not where the whole interval is on one side."""
    if found is None:
        return "not measured"
    value, interval = found
    low, high = interval or (value, value)
    if below:
        low, high, wanted = -high, -low, -wanted
    if low >= wanted:
        return "reached"
    return "**not reached**" if high < wanted else "undecided"


def faster(rows, task, peer, least, wanted_mm):
    """Whether ours is so many times as fast as a peer, each at its fastest setting within the wanted error."""
    ours, theirs = (fastest_within(rows, task, name, wanted_mm) for name in ("spinebench", peer))
    if not ours or not theirs:
        return f"| {peer} at ≤ {wanted_mm} mm | ≥ {least} | – | not measured: no setting is |"
    found = ratio(theirs, ours)
    words = f"{peer} at ≤ {wanted_mm} mm ({theirs[0]['setting']}) over ours ({ours[0]['setting']})"
    return f"| {words} | ≥ {least} | {with_interval(found)} | {verdict(found, least)} |"


def at_most(words, costs, most_us):
    """Whether times of the rounds, µs, are below a bound in the mean."""
    middle = statistics.fmean(costs)
    half = STUDENT.get(len(costs) - 1, 1.96) * statistics.stdev(costs) / math.sqrt(len(costs)) if len(costs) > 1 else 0.0
    interval = (middle - half, middle + half)
    found = f"{middle:.1f} µs ({interval[0]:.1f}–{interval[1]:.1f})"
    return f"| {words} | ≤ {most_us:g} µs | {found} | {verdict((middle, interval), most_us, below=True)} |"


def goals(rows, wanted_mm):
    lines = ["| Comparison | Required | Measured | |", "| --- | ---: | ---: | --- |"]
    lines += [faster(rows, "tensions", "PyElastica", 100, wanted_mm), faster(rows, "lengths", "MuJoCo hinge chain", 10, wanted_mm)]
    stepped, played = (of(rows, task="call", setting=name) for name in ("one call a step", "one call for all steps"))
    costs = [1e6 * (a["cpu_s_per_step"] - b["cpu_s_per_step"]) for a in stepped for b in played if a["round"] == b["round"]]
    lines.append(at_most("a call of `Rod.step` from Python beyond the step itself", costs, 20))
    costs = [1e6 * row["cpu_s_per_step"] for row in of(rows, task="overhead")]
    lines.append(at_most("`env.step` through Gymnasium of a robot that costs nothing (constant curvature)", costs, 20))
    cores = max(row["threads"] for row in rows)
    for threads, key, words in ((1, "cpu_s_per_step", "one core"), (cores, "wall_s_per_step", f"{cores} cores, wall clock")):
        stepped, played = (
            of(rows, task="vector", setting=name, threads=threads) for name in ("one call a step", "one call for all steps")
        )
        found = ratio(played, stepped, key)
        title = f"vector of 256 environments, rate over that of one call for all steps; {words}"
        lines.append(f"| {title} | ≥ 0.9 | {with_interval(found)} | {verdict(found, 0.9)} |")
    return lines


def markdown(rows, wanted_mm):
    note = (
        "Steps of 0.2 s; processor time, geometric means over the rounds; ratios within rounds with their 95 % interval, over the "
        f"fastest of our settings within {wanted_mm} mm (**1**). Two side by side: twice the rate of one of two processes at the same time."
    )
    return "\n".join([*speeds(rows, wanted_mm), "", note, "", *goals(rows, wanted_mm), ""])
