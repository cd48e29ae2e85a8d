#!/usr/bin/env python3
"""Draws the reference pictures of all scenes again, or of those named.

tests/reference/renew.py [--program build/release/typodont] [--samples 160] [NAME …]
"""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def export(program, wanted, folder):
    command = [program, "render", ROOT / f"assets/scenes/{wanted['scene']}.json", "--rig", "closeup", "--eye", "left"]
    command += ["--size", "640x512", "--geometry", "--out", folder]
    if wanted.get("finished"):
        command.append("--finished")
    if "tool_mm" in wanted:
        hand = pathlib.Path(folder) / "hand.csv"
        pose = ",".join(str(x) for x in wanted["tool_mm"]) + ",1,0,0,0"
        hand.write_text(f"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,{pose},0\n")
        command += ["--pose", hand]
    subprocess.run(command, check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", default=ROOT / "build/release/typodont")
    parser.add_argument("--samples", type=int, default=160)
    options = parser.parse_args()
    for wanted in json.loads((HERE / "scenes.json").read_text()):
        if options.names and wanted["name"] not in options.names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            export(options.program, wanted, folder)
            picture = HERE / (wanted["name"] + ".png")
            blender = ["blender", "-b", "--python-exit-code", "1", "-P", HERE / "draw.py", "--"]
            # Debian's Blender needs the system's Python with numpy, not another one on the user's path.
            system = {**os.environ, "PATH": "/usr/bin:/bin"}
            subprocess.run([*blender, folder, picture, str(options.samples)], check=True, env=system)


main()
