#!/usr/bin/env python3
"""Makes the Markdown tables of a results.json: `python3 table.py results.json`."""

import json
import sys
from statistics import median

from workloads import (
    COLD,
    FRAMES,
    LARGE_TRIANGLES,
    SETTINGS,
    TEXTURED,
    WARM,
    WARM_TITLES,
    cold_against,
    textured_against,
)


def markdown(results):
    runs = results["runs"]
    parts = [about(results)]
    if "cold" in runs:
        parts.append(cold(runs["cold"]))
    warm = [name for name in WARM if f"warm-{name}" in runs]
    if warm:
        parts.append(frames(runs, warm))
    if "textured" in runs:
        parts.append(textured(runs["textured"], runs.get("textured-plain", {})))
    if "large" in runs:
        parts.append(large(runs["large"]))
    if "models" in runs:
        parts.append(models(runs["models"]))
    return "\n".join(parts)


def about(results):
    machine = results["machine"]
    lines = [
        f"Measured {results['date']} with `{results['command']}`: {machine['cpu']}, {machine['cores']} cores, "
        f"{machine['kernel']}, load average {machine['load_before'][0]} before and {machine['load_after'][0]} after. "
        f"Processor time is user and system time of all threads: median (least–most), interleaved, rounds done: "
        f"{results['rounds']}. × is the median of the ratios to overcoat within a round: to the row of overcoat that "
        "draws most alike; for start to PNG to 8 samples, with the built-in studio where a peer reads no environment.",
        "",
    ]
    lines += [f"- {name}: {version}" for name, version in results["versions"].items()]
    lines += [f"- {name}: not measured: {reason}" for name, reason in results["left_out"].items()]
    return "\n".join(lines) + "\n"


def values(entries, key, scale=1.0):
    return [entry[key] * scale for entry in entries if key in entry]


def spread(numbers):
    if len(numbers) == 1:
        return number(numbers[0])
    return f"{number(median(numbers))} ({number(min(numbers))}–{number(max(numbers))})"


def number(value):
    """Three significant digits, as a plain number."""
    if value == 0.0:
        return "0"
    digits = 2
    while digits > 0 and abs(value) >= 10 ** (3 - digits):
        digits -= 1
    if abs(value) < 1.0:
        digits = 3
    return f"{value:.{digits}f}"


def ratio(entries, ours, key):
    """Median over the rounds of theirs / ours."""
    mine = {entry["round"]: entry[key] for entry in ours or [] if entry.get(key)}
    ratios = [entry[key] / mine[entry["round"]] for entry in entries if key in entry and entry["round"] in mine]
    return f"×{number(median(ratios))}" if ratios else ""


def rows(title, header, lines):
    out = [f"**{title}**", "", f"| {' | '.join(header)} |", "|" + "---|" * len(header)]
    return "\n".join(out + [f"| {' | '.join(line)} |" for line in lines]) + "\n"


def cold(runs):
    lines = []
    for key in COLD:
        if key not in runs:
            continue
        setting, entries = SETTINGS[key], runs[key]
        startup = values(entries, "startup_cpu_s")
        # The comparison that is kindest to the peer: without the start of Python and its libraries.
        bare = [{**e, "bare_s": e["cpu_s"] - e["startup_cpu_s"]} for e in entries]
        ours = [{**e, "bare_s": e["cpu_s"]} for e in runs.get(cold_against(setting), [])]
        python = number(median(startup)) if any(startup) else "–"
        lines.append(
            [
                setting.title,
                setting.draws,
                spread(values(entries, "cpu_s")),
                python,
                "" if setting.peer == "overcoat" else ratio(bare, ours, "bare_s"),
                number(median(values(entries, "wall_s"))),
                number(median(values(entries, "peak_mib"))),
            ]
        )
    header = [
        "5k triangles, 512x512",
        "draws",
        "processor s",
        "of it Python s",
        "× overcoat, without Python",
        "wall s",
        "peak MiB",
    ]
    return rows("From start to PNG", header, lines)


def frames(runs, columns):
    lines = []
    for key in FRAMES:
        cells = []
        for name in columns:
            entries = runs[f"warm-{name}"].get(key)
            if not entries:
                cells.append("–")
                continue
            ours = runs[f"warm-{name}"].get(SETTINGS[key].against)
            cells.append(f"{spread(values(entries, 'frame_cpu_ms'))} {ratio(entries, ours, 'frame_cpu_ms')}".strip())
        if any(cell != "–" for cell in cells):
            lines.append([SETTINGS[key].title, SETTINGS[key].draws, *cells])
    header = ["Processor ms a frame, read back, 512x512", "draws", *(WARM_TITLES[name] for name in columns)]
    return rows("Warm frames", header, lines)


def textured(runs, plain):
    lines = []
    for key in TEXTURED:
        if key not in runs:
            continue
        setting, entries = SETTINGS[key], runs[key]
        lines.append(
            [
                setting.title,
                setting.draws,
                spread(values(plain[key], "frame_cpu_ms")) if key in plain else "–",
                spread(values(entries, "frame_cpu_ms")),
                ratio(entries, plain.get(key), "frame_cpu_ms"),
                ratio(entries, runs.get(textured_against(setting)), "frame_cpu_ms"),
            ]
        )
    header = [
        "5k triangles, 512x512, read back",
        "draws",
        "without textures, processor ms a frame",
        "with three of 2048x2048",
        "× without",
        "× overcoat, both with",
    ]
    return rows("Textures", header, lines)


def large(runs):
    lines = []
    for key, entries in runs.items():
        ms = values(entries, "frame_cpu_ms")
        rate = [LARGE_TRIANGLES / 1e6 / (value / 1e3) for value in ms]
        ours = runs.get(SETTINGS[key].against)
        lines.append(
            [
                SETTINGS[key].title,
                SETTINGS[key].draws,
                spread(ms),
                number(median(rate)),
                ratio(entries, ours, "frame_cpu_ms"),
                number(median(values(entries, "peak_mib"))),
            ]
        )
    header = ["5M triangles, 512x512", "draws", "processor ms a frame", "Mtri per processor s", "time ×", "peak MiB"]
    return rows("Large mesh", header, lines)


def models(runs):
    lines = []
    for key, entries in runs.items():
        ms = values(entries, "frame_cpu_ms")
        ours = runs.get(SETTINGS[key].against)
        lines.append(
            [
                SETTINGS[key].title,
                SETTINGS[key].draws,
                spread(ms),
                number(1e3 / median(ms)),
                ratio(entries, ours, "frame_cpu_ms"),
            ]
        )
    header = ["Load, draw, read back; 3k to 40k triangles", "draws", "processor ms a model", "models per processor s", "time ×"]
    return rows("A new model each time", header, lines)


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        print(markdown(json.load(file)), end="")
