#!/usr/bin/env python3
"""Draws the reference pictures of all scenes again, or of those named.

tests/reference/renew.py [--program build/release/typodont] [--samples 128] [NAME …]

With --compare it draws no reference. It writes docs/pictures/looks_NAME.jpg instead: the picture of the program
--before, the picture of the program, and the reference. With --scenes it writes docs/pictures/scene_NAME.jpg for each
scene of assets/scenes: the picture of the program --before, and the picture of the program.
"""

import argparse
import json
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def draw(program, wanted, folder, *more, assets=ROOT / "assets"):
    own = HERE / f"{wanted['scene']}.json"
    scene = own if own.exists() else f"{assets}/scenes/{wanted['scene']}.json"
    command = [program, "render", scene, "--eye", "left"]
    command += ["--rig", wanted.get("rig", "closeup")]
    command += ["--size", "640x512", "--out", folder, *more]
    if wanted.get("finished"):
        command.append("--finished")
    if "tool_mm" in wanted:
        hand = pathlib.Path(folder) / "hand.csv"
        hand.parent.mkdir(exist_ok=True)
        pose = ",".join(str(x) for x in wanted["tool_mm"]) + ",1,0,0,0"
        hand.write_text(f"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,{pose},0\n")
        command += ["--pose", hand]
    subprocess.run(command, check=True, env={**os.environ, "TYPODONT_ASSETS": str(assets)})


def reference(program, wanted, samples):
    with tempfile.TemporaryDirectory() as folder:
        draw(program, wanted, folder, "--geometry")
        picture = HERE / (wanted["name"] + ".png")
        blender = ["blender", "-b", "--python-exit-code", "1", "-P", HERE / "draw.py", "--"]
        # Debian's Blender needs the system's Python with numpy, not another one on the user's path.
        system = {**os.environ, "PATH": "/usr/bin:/bin"}
        subprocess.run([*blender, folder, str(samples)], check=True, env=system)
        subprocess.run([HERE / "develop.py", folder, picture], check=True, env=system)


def side_by_side(pictures, out, width=None, quality=4):
    command = ["ffmpeg", "-y", "-v", "error"]
    for picture in pictures:
        command += ["-i", picture]
    joined = f"hstack=inputs={len(pictures)}" if len(pictures) > 1 else "null"
    if width:
        joined += f",scale={width * len(pictures)}:-2:flags=area"
    subprocess.run([*command, "-filter_complex", joined, "-q:v", str(quality), out], check=True)


def before_and_now(program, before, wanted, folder, *more):
    pictures = []
    if before:
        draw(f"{before}/typodont", wanted, folder + "/before", *more, assets=f"{before}/assets")
        pictures.append(folder + "/before/left.png")
    draw(program, wanted, folder + "/now", *more)
    return [*pictures, folder + "/now/left.png"]


def compare(program, before, wanted):
    with tempfile.TemporaryDirectory() as folder:
        # With --geometry, the tool is drawn without its handpiece, as in the reference.
        pictures = before_and_now(program, before, wanted, folder, "--geometry") + [HERE / (wanted["name"] + ".png")]
        side_by_side(pictures, ROOT / f"docs/pictures/looks_{wanted['name']}.jpg")


def show_scene(program, before, name):
    with tempfile.TemporaryDirectory() as folder:
        rig = "hip" if name == "acetabular-reaming" else "closeup"  # the rig that shows the whole bone
        pictures = before_and_now(program, before, {"scene": name, "rig": rig}, folder)
        side_by_side(pictures, ROOT / f"docs/pictures/scene_{name}.jpg", width=400, quality=5)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", default=ROOT / "build/release/typodont")
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("-c", "--compare", action="store_true", help="write the pictures of docs/looks.md")
    parser.add_argument("-b", "--before", help="folder with an older program and its assets, for a comparison")
    parser.add_argument("--scenes", action="store_true", help="write a picture of each scene of assets/scenes")
    options = parser.parse_args()
    if options.scenes:
        for scene in sorted((ROOT / "assets/scenes").glob("*.json")):
            if not options.names or scene.stem in options.names:
                show_scene(options.program, options.before, scene.stem)
        return
    for wanted in json.loads((HERE / "scenes.json").read_text()):
        if options.names and wanted["name"] not in options.names:
            continue
        if options.compare:
            compare(options.program, options.before, wanted)
        else:
            reference(options.program, wanted, options.samples)


main()
