"""Holds the demo's summary against what the demo promises."""

import json
import sys

summary = json.load(open(sys.argv[1]))
outcome = next(s["consolidate"] for s in summary["stages"] if "consolidate" in s)
d, samples = outcome["drained_share"], outcome["samples"]


def terzaghi(t):
    """Degree of consolidation by Terzaghi's series; enough terms for t > 0.01."""
    from math import exp, pi

    return 1 - sum(2 / m**2 * exp(-(m**2) * t) for m in (pi / 2 * (2 * k + 1) for k in range(100)))


within = [s for s in samples if 0.1 <= s["time_factor"] <= 1.5]
worst = max(abs(s["degree"] - d - (1 - d) * terzaghi(s["time_factor"] / (1 - d) ** 2)) for s in within)
checks = {
    "all stages are done": summary["finished"],
    "the course reaches T_v = 1.5": samples[-1]["time_factor"] >= 1.5,
    f"within 0.04 of Terzaghi with the drained layer (worst {worst:.3f})": len(within) > 50 and worst <= 0.04,
    "the solves are exact": summary["largest_residual"] < 1e-12,
}
for what, holds in checks.items():
    print("ok  " if holds else "FAIL", what)
print(f"{sum(map(bool, checks.values()))} passed, {sum(not c for c in checks.values())} failed")
sys.exit(not all(checks.values()))
