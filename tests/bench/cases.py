"""Campaign of the case factory: share of valid cases, times and scores of each family. `./run cases [SEEDS]`."""
import json, statistics, subprocess, sys, tempfile, time

program, seeds = sys.argv[1], int(sys.argv[2])
listed = subprocess.run([program, "case", "--list"], capture_output=True, text=True, check=True).stdout
print("| family | difficulty | valid | median s | max s | exact plan, min | careless hand, max |")
print("|---|---|---|---|---|---|---|")
refused = []
with tempfile.TemporaryDirectory() as folder:
    for family in [line.split(":")[0] for line in listed.splitlines()]:
        for difficulty in (0, 0.5, 1):
            times, exact, careless = [], [], []
            for seed in range(1, seeds + 1):
                began = time.monotonic()
                made = subprocess.run([program, "case", family, "--seed", str(seed), "--difficulty", str(difficulty),
                                       "--json", "--out", folder + "/case.json"], capture_output=True, text=True)
                times.append(time.monotonic() - began)
                if made.returncode:
                    refused.append(f"{family} {difficulty} {seed}: {made.stderr.strip().splitlines()[-1]}")
                    continue
                case = json.loads(made.stdout)
                exact.append(case["expert_points"])
                careless.append(case["careless_points"])
            print(f"| {family} | {difficulty} | {len(exact)}/{seeds} | {statistics.median(times):.1f} | "
                  f"{max(times):.1f} | {min(exact, default=0):.1f} | {max(careless, default=0):.1f} |", flush=True)
print("\n".join(refused))
