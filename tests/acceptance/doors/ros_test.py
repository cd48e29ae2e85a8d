"""ROS as its user has it: ros_test.py PROGRAM DEVEL, the latter a workspace in which catkin built engine/bindings/ros. A live
session's states, forces and end come as topics, and those agree with each other."""

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAM, DEVEL = os.path.abspath(sys.argv[1]), Path(sys.argv[2])
BALL = {
    "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]},
    "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics"],
}
HAND = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3.5,1,0,0,0,1\n3600,0,0,3.4,1,0,0,0,1\n"


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def until(done):
    for _ in range(6000):
        if done():
            return
        time.sleep(0.01)
    raise AssertionError("waited for a minute")


def listens(port):
    with socket.socket() as s:
        return s.connect_ex(("127.0.0.1", port)) == 0


with tempfile.TemporaryDirectory() as folder:
    master, stream = free_port(), free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{master}", ROS_IP="127.0.0.1", ROS_HOME=folder,
                      PYTHONPATH=str(DEVEL / "lib/python3/dist-packages"))
    sys.path.insert(0, os.environ["PYTHONPATH"])
    Path(folder, "ball.json").write_text(json.dumps(BALL))
    Path(folder, "hand.csv").write_text(HAND)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    started = [subprocess.Popen(["rosmaster", "--core", "-p", str(master)], **quiet)]
    try:
        until(lambda: listens(master))
        started.append(subprocess.Popen([sys.executable, DEVEL / "lib/typodont_ros/typodont_bridge",
                                         f"_address:=127.0.0.1:{stream}"], **quiet))
        import rospy
        from geometry_msgs.msg import PoseStamped, WrenchStamped
        from typodont_ros.msg import Event, State

        rospy.init_node("test", disable_signals=True)
        told, subscribers = {}, []
        for name, kind in {"state": State, "event": Event, "tool": PoseStamped, "wrench": WrenchStamped}.items():
            told[name] = []
            subscribers.append(rospy.Subscriber(f"/typodont_bridge/{name}", kind, told[name].append))
        until(lambda: all(subscriber.get_num_connections() for subscriber in subscribers))
        session = subprocess.Popen([PROGRAM, "run", "ball.json", "--hand", "script:hand.csv", "--audio", "none:", "--stream",
                                    f"ws:{stream}", "--stream-rate", "50"], **quiet)
        started.append(session)
        until(lambda: len(told["state"]) > 20 and told["state"][-1].wrench.force.z > 0)
        session.send_signal(signal.SIGINT)
        until(lambda: any(event.kind == "end" for event in told["event"]))
        state = told["state"][-1]
        assert state.header.frame_id == "typodont" and abs(state.header.stamp.to_sec() - time.time()) < 600, state.header
        assert abs(state.hand.position.z - 3.5e-3) < 1e-5 and state.hand.orientation.w == 1, state.hand
        assert dict(zip(state.removed_tissues, state.removed))["enamel"] > 0, state.removed
        assert state.tool_name == "round_012" and state.tissue == "enamel", state


        def of_this_tick(name):
            return [message for message in told[name] if message.header.stamp == state.header.stamp]

        until(lambda: of_this_tick("wrench") and of_this_tick("tool"))
        assert of_this_tick("wrench")[0].wrench == state.wrench and of_this_tick("tool")[0].pose == state.tool
        print(len(told["state"]), "states,", len(told["event"]), "events")
    finally:
        for process in started:
            process.kill()
            process.wait()
