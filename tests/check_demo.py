"""Holds the demo's summary against what the demo promises."""

import json
import sys

summary = json.load(open(sys.argv[1]))
outcome = next(s["consolidate"] for s in summary["stages"] if "consolidate" in s)
s, b, samples = outcome["drained_settlement"], outcome["sealed_settlement"], outcome["samples"]


def terzaghi(t):
    """Degree of consolidation with the layers at the walls (docs/oedometer.md); enough terms for t > 0.01."""
    from math import cos, exp, pi, sin

    tau, r = t / (1 - s - b), b / (1 - s - b)
    left = 0
    for k in range(60):
        low, high = k * pi, (k + 0.5) * pi
        for _ in range(60):
            beta = (low + high) / 2
            root_is_above = (cos(beta) - r * beta * sin(beta)) * (-1) ** k > 0
            low, high = (beta, high) if root_is_above else (low, beta)
        norm = (1 + r / (1 + (r * beta) ** 2)) / 2
        left += exp(-(beta**2) * tau) / (beta**2 * norm * (1 + r))
    return 1 - (1 - s) * left


within = [x for x in samples if 0.03 <= x["time_factor"] <= 1.5]
worst = max(abs(x["degree"] - terzaghi(x["time_factor"])) for x in within)
within_bound = len(within) > 50 and worst <= 0.02
checks = {
    "all stages are done": summary["finished"],
    "the course reaches T_v = 1.5": samples[-1]["time_factor"] >= 1.5,
    f"within 0.02 of Terzaghi with the layers at the walls (worst {worst:.3f})": within_bound,
    "the solves are exact": summary["largest_residual"] < 1e-12,
}
for what, holds in checks.items():
    print("ok  " if holds else "FAIL", what)
print(f"{sum(map(bool, checks.values()))} passed, {sum(not c for c in checks.values())} failed")
sys.exit(not all(checks.values()))
