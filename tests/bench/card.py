#!/usr/bin/env python3
"""Measures the pictures on another machine, one with a graphics card, in at most 6 minutes.

    tests/bench/card.py bundle PROGRAM OUT.tar    here: packs program, libraries, assets and this script (`./run card`)
    tar xf OUT.tar && card/card.py measure        there: prints tables in Markdown
"""
import argparse, glob, json, os, pathlib, re, resource, subprocess, sys, tarfile, tempfile, time

HERE = pathlib.Path(__file__).resolve().parent
# Every machine has its own. The card's driver is not among the libraries, because the Vulkan loader opens it by itself.
OF_THE_SYSTEM = re.compile(r"ld-linux|lib(c|m|dl|rt|pthread|resolv)\.so")
POSE = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,6.8,5.5,19,1,0,0,0,1\n"  # above the teeth of the shipped scenes


def bundle(program, out):
    program = pathlib.Path(program).resolve()
    with tarfile.open(out, "w:gz") as tar:
        tar.add(__file__, "card/card.py")
        tar.add(HERE.parents[1] / "assets", "card/assets")
        libraries = {}
        for file in program, program.with_name("typodont-openvdb"):
            tar.add(file, f"card/{file.name}")
            listed = subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout
            libraries.update(re.findall(r"(\S+) => (/\S+)", listed))
        for name, file in sorted(libraries.items()):
            if not OF_THE_SYSTEM.match(name):
                tar.add(os.path.realpath(file), f"card/lib/{name}")
    print(f"wrote {out}; on the machine with the card: tar xf {os.path.basename(out)} && python3 card/card.py measure")


def install_missing():
    """Makes the libraries that this machine lacks known to its loader: child processes have no LD_LIBRARY_PATH."""
    known = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=True,
                           env={"PATH": "/usr/sbin:/sbin:/usr/bin:/bin"}).stdout.split()
    missing = [file for file in (HERE / "lib").glob("*") if file.name not in known]
    if missing:
        folder = HERE / "missing"
        folder.mkdir(exist_ok=True)
        for file in missing:
            file.replace(folder / file.name)
    if (HERE / "missing").exists():
        pathlib.Path("/etc/ld.so.conf.d/typodont-card.conf").write_text(f"{HERE}/missing\n")
        subprocess.run(["ldconfig"], check=True)
    # In some containers, the driver lies where no loader searches.
    aside = glob.glob("/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd*.json")
    if aside and not glob.glob("/usr/share/vulkan/icd.d/nvidia*") + glob.glob("/etc/vulkan/icd.d/nvidia*"):
        os.environ["VK_DRIVER_FILES"] = os.environ["VK_ICD_FILENAMES"] = aside[0]


def measure(scenes, levels, sizes, seconds):
    install_missing()
    end = time.monotonic() + seconds
    frames, passes, gpu, device = [], [], {}, "nothing"
    with tempfile.TemporaryDirectory() as folder:
        pose = pathlib.Path(folder, "pose.csv")
        pose.write_text(POSE)
        for scene in scenes:
            for level in levels:
                cells, cold = [], ""
                # The first size begins with an empty cache. The later ones use the light that it has computed.
                environment = os.environ | {"TYPODONT_CACHE": tempfile.mkdtemp(dir=folder)}
                for size in sizes:
                    began, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
                    try:
                        ran = subprocess.run(
                            [HERE / "typodont", "render", scene, "--pose", pose, "--size", size, "--quality", level,
                             "--out", folder + "/pictures", "--json"],
                            capture_output=True, text=True, env=environment, timeout=max(end - began, 0.01))
                    except subprocess.TimeoutExpired:
                        cells.append("no time left")
                        continue
                    if ran.returncode:
                        sys.exit(ran.stderr)
                    now = resource.getrusage(resource.RUSAGE_CHILDREN)
                    frame = json.loads(ran.stdout)
                    device, gpu = frame["device"], frame["timing"]["gpu_parts_ms"]
                    cells.append(f"{frame['timing']['frame_ms']:.1f}")
                    passes.append([scene, level, size] + [f"{ms:.2f}" for ms in gpu.values()])
                    if not cold:
                        busy = now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime
                        cold = f"{time.monotonic() - began:.1f} | {busy:.1f}"
                frames.append([scene, level] + cells + [cold or "– | –"])
    cores = len(os.sched_getaffinity(0))
    print(f"Drawn by {device}, {cores} cores. Both eyes, pixels of an eye, every pixel drawn anew, median without the "
          f"first frame, ms; the command with an empty cache, at {sizes[0]}:\n")
    table(["scene", "level"] + sizes + ["cold command, s", "core-seconds"], frames)
    print("\nGPU time of each pass, median, ms:\n")
    table(["scene", "level", "size"] + list(gpu), passes)


def table(head, rows):
    for row in [head, ["---"] * len(head)] + rows:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    pack = commands.add_parser("bundle")
    pack.add_argument("program")
    pack.add_argument("out")
    there = commands.add_parser("measure")
    there.add_argument("--scenes", default="molar-caries,crown-preparation,implant-molar")
    there.add_argument("--levels", default="high,medium,low,fast")
    there.add_argument("--sizes", default="1280x1024,2064x2208")
    there.add_argument("--seconds", type=float, default=340, help="commands that begin later are left out")
    given = parser.parse_args()
    if given.command == "bundle":
        bundle(given.program, given.out)
    else:
        measure(given.scenes.split(","), given.levels.split(","), given.sizes.split(","), given.seconds)
