// A tooth in Unity: put this on a GameObject, Typodont.cs and libtypodont.so into Assets/Plugins. The servo runs at 1 kHz on
// a thread of its own, the tissue in Update(), its surface as one mesh a brick, changed in place. `tool` is what the
// hand moves (metres; Unity's y and z are swapped, because W's z points up).
//
// Compiled where Unity is. The test of this folder compiles and runs Typodont.cs, over which it stands.
#if UNITY_5_3_OR_NEWER
using System.Collections.Generic;
using System.Diagnostics;
using System.Threading;
using Typodont;
using UnityEngine;

public class TypodontTooth : MonoBehaviour {
  public string scene = "molar-caries";
  public Transform tool, shownTool;
  public Material material;
  public float pedal;
  public Vector3 force;  // N, of the newest tick: for a device

  Core core;
  Servo servo;
  Thread thread;
  volatile bool going = true;
  readonly object gate = new object();
  Vector3 hand, proxy;
  readonly Dictionary<Vector3Int, Mesh> bricks = new Dictionary<Vector3Int, Mesh>();

  static Vector3 ToUnity(Typodont.Vector v) { return new Vector3((float)v.X, (float)v.Z, (float)v.Y); }
  static Typodont.Vector ToW(Vector3 v) { return new Typodont.Vector(v.x, v.z, v.y); }

  void Start() {
    using (var opened = Scene.Open(scene)) core = new Core(opened);
    hand = transform.InverseTransformPoint(tool.position);
    servo = core.GiveServo(ToW(hand));
    thread = new Thread(Feel) { Priority = System.Threading.ThreadPriority.Highest };
    thread.Start();
  }

  void Feel() {
    var clock = Stopwatch.StartNew();
    var sample = new Sample();
    var tick = new Tick();
    for (long i = 0; going; ++i) {
      while (clock.Elapsed.TotalMilliseconds < i) Thread.SpinWait(50);
      lock (gate) sample.XWT = new Pose(ToW(hand));
      sample.TNs = i * 1000000;
      sample.Pedal = pedal;
      servo.Step(ref sample, ref tick);
      lock (gate) {
        force = ToUnity(tick.Force);
        proxy = ToUnity(tick.XWG.P);
      }
    }
  }

  void Update() {
    lock (gate) {
      hand = transform.InverseTransformPoint(tool.position);
      shownTool.position = transform.TransformPoint(proxy);
    }
    core.Carve();
    foreach (var brick in core.Mesh()) Show(brick);
  }

  void Show(Brick brick) {
    var key = new Vector3Int(brick.X, brick.Y, brick.Z);
    Mesh mesh;
    if (!bricks.TryGetValue(key, out mesh)) {
      var part = new GameObject("brick", typeof(MeshFilter), typeof(MeshRenderer));
      part.transform.SetParent(transform, false);
      part.GetComponent<MeshRenderer>().material = material;
      mesh = bricks[key] = part.GetComponent<MeshFilter>().mesh;
      mesh.MarkDynamic();
    }
    var corners = new Vector3[brick.Vertices.Length];
    var normals = new Vector3[corners.Length];
    for (int i = 0; i < corners.Length; ++i) {
      var v = brick.Vertices[i];
      corners[i] = new Vector3(v.X, v.Z, v.Y);
      normals[i] = new Vector3(v.Nx, v.Nz, v.Ny);
    }
    // Unity draws triangles that are clockwise from outside; here they are the other way round.
    for (int i = 0; i < brick.Triangles.Length; i += 3)
      (brick.Triangles[i + 1], brick.Triangles[i + 2]) = (brick.Triangles[i + 2], brick.Triangles[i + 1]);
    mesh.Clear();
    mesh.vertices = corners;
    mesh.normals = normals;
    mesh.triangles = brick.Triangles;
  }

  void OnDestroy() {
    going = false;
    if (thread != null) thread.Join();
    if (servo != null) servo.Dispose();
    if (core != null) core.Dispose();
  }
}
#endif
