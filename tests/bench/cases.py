"""Campaign of the case factory: share of valid cases, times and scores of each family. `./run cases [SEEDS]`."""
import json, statistics, subprocess, sys, tempfile, time

program, seeds = sys.argv[1], int(sys.argv[2])


def ask(*arguments, check=False):
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=check)


def points_with_servo(folder):
    """Points of the simulated expert in the case, with the servo; `-`: it fails."""
    session = folder + "/expert.h5"
    if ask("servo", folder + "/case.json", "--hand", "expert:", "--out", session).returncode:
        return "-"
    report = ask("report", session, "--out", folder + "/report.html", "--json")
    return "-" if report.returncode else f"{json.loads(report.stdout)['points']:.1f}"


listed = ask("case", "--list", check=True).stdout
print("| family | difficulty | valid | median s | max s | exact plan, min | careless hand, max | expert with servo |")
print("|---|---|---|---|---|---|---|---|")
refused = []
with tempfile.TemporaryDirectory() as folder:
    for family in [line.split(":")[0] for line in listed.splitlines()]:
        for difficulty in (0, 0.5, 1):
            times, exact, careless, servo = [], [], [], ""
            for seed in range(1, seeds + 1):
                began = time.monotonic()
                made = ask("case", family, "--seed", str(seed), "--difficulty", str(difficulty), "--json",
                           "--out", folder + "/case.json")
                times.append(time.monotonic() - began)
                if made.returncode:
                    refused.append(f"{family} {difficulty} {seed}: {made.stderr.strip().splitlines()[-1]}")
                    continue
                case = json.loads(made.stdout)
                exact.append(case["expert_points"])
                careless.append(case["careless_points"])
                if difficulty == 0.5 and not servo:
                    servo = points_with_servo(folder)
            print(f"| {family} | {difficulty} | {len(exact)}/{seeds} | {statistics.median(times):.1f} | "
                  f"{max(times):.1f} | {min(exact, default=0):.1f} | {max(careless, default=0):.1f} | {servo} |",
                  flush=True)
print("\n".join(refused))
