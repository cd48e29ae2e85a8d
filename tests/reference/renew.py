#!/usr/bin/env python3
"""Draws the reference pictures of all scenes again, or of those named.

tests/reference/renew.py [--program build/release/typodont] [--samples 128] [NAME …]

With --compare it draws no reference. It writes docs/pictures/looks_NAME.jpg instead: the picture of the program, and
the reference.
"""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def draw(program, wanted, folder):
    own = HERE / f"{wanted['scene']}.json"
    scene = own if own.exists() else ROOT / f"assets/scenes/{wanted['scene']}.json"
    # With --geometry, the tool is drawn without its handpiece, as in the reference.
    command = [program, "render", scene, "--eye", "left", "--rig", "closeup", "--size", "640x512", "--out", folder,
               "--geometry"]
    if wanted.get("finished"):
        command.append("--finished")
    if "tool_mm" in wanted:
        hand = pathlib.Path(folder) / "hand.csv"
        hand.parent.mkdir(exist_ok=True)
        pose = ",".join(str(x) for x in wanted["tool_mm"]) + ",1,0,0,0"
        hand.write_text(f"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,{pose},0\n")
        command += ["--pose", hand]
    subprocess.run(command, check=True, env={**os.environ, "TYPODONT_ASSETS": str(ROOT / "assets")})


def reference(program, wanted, samples):
    with tempfile.TemporaryDirectory() as folder:
        draw(program, wanted, folder)
        picture = HERE / (wanted["name"] + ".png")
        blender = ["blender", "-b", "--python-exit-code", "1", "-P", HERE / "draw.py", "--"]
        # Debian's Blender needs the system's Python with numpy, not another one on the user's path.
        system = {**os.environ, "PATH": "/usr/bin:/bin"}
        subprocess.run([*blender, folder, str(samples)], check=True, env=system)
        subprocess.run([HERE / "develop.py", folder, picture], check=True, env=system)


def compare(program, wanted):
    with tempfile.TemporaryDirectory() as folder:
        draw(program, wanted, folder)
        subprocess.run(["ffmpeg", "-y", "-v", "error", "-i", folder + "/left.png", "-i", HERE / (wanted["name"] + ".png"),
                        "-filter_complex", "hstack", "-q:v", "4", ROOT / f"docs/pictures/looks_{wanted['name']}.jpg"],
                       check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", default=ROOT / "build/release/typodont")
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("-c", "--compare", action="store_true", help="write the pictures of docs/looks.md")
    options = parser.parse_args()
    for wanted in json.loads((HERE / "scenes.json").read_text()):
        if options.names and wanted["name"] not in options.names:
            continue
        if options.compare:
            compare(options.program, wanted)
        else:
            reference(options.program, wanted, options.samples)


main()
