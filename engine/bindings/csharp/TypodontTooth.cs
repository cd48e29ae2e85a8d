// A tooth in Unity. Put this on a GameObject, and Typodont.cs and libtypodont.so into Assets/Plugins. The servo runs at
// 1 kHz on its own thread, the tissue on a second thread.
// Each brick of the surface is one mesh, and Update() replaces only those that changed. `tool` is the hand (metres;
// Unity's y and z are exchanged, because z of W points up). `shownTool` follows the hand but stays outside the tissue.
//
// Tests compile this file with mcs and run it with declarations of the Unity types that it uses. It was never run in
// Unity.
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
  public Vector3 force;  // N, force of the newest tick, for a device

  Core core;
  Servo servo;
  Thread servoThread, tissueThread;
  volatile bool going = true;
  readonly object gate = new object();      // protects hand, proxy and force; locked only to copy them
  readonly object coreGate = new object();  // protects the core; the servo's thread never locks it
  Vector3 hand, proxy;
  readonly Dictionary<Vector3Int, Mesh> bricks = new Dictionary<Vector3Int, Mesh>();

  static Vector3 ToUnity(Typodont.Vector v) { return new Vector3((float)v.X, (float)v.Z, (float)v.Y); }
  static Typodont.Vector ToW(Vector3 v) { return new Typodont.Vector(v.x, v.z, v.y); }

  void Start() {
    using (var opened = Scene.Open(scene)) core = new Core(opened);
    hand = transform.InverseTransformPoint(tool.position);
    servo = core.GiveServo(ToW(hand));
    servoThread = new Thread(Feel) { Priority = System.Threading.ThreadPriority.Highest };
    tissueThread = new Thread(Carve);
    servoThread.Start();
    tissueThread.Start();
  }

  // Update() moves the hand once per frame, so the servo's hand follows it smoothly, with a time constant of 20 ms. If
  // the hand jumped once per frame, the energy ledger would expect a jump back and reduce the force
  // (docs/passivity.md).
  void Feel() {
    const float share = 0.05f;  // fraction of the remaining distance moved in each tick
    Vector3 felt = hand;
    var clock = Stopwatch.StartNew();
    var sample = new Sample();
    var tick = new Tick();
    for (long i = 0; going; ++i) {
      while (clock.Elapsed.TotalMilliseconds < i) Thread.SpinWait(50);
      Vector3 next;
      lock (gate) next = felt + share * (hand - felt);
      sample.XWT = new Pose(ToW(next));
      sample.TNs = i * 1000000;
      sample.Pedal = pedal;
      try {
        servo.Step(ref sample, ref tick);
      } catch (TypodontException) {  // invalid pose: zero force until the next valid pose
        lock (gate) force = Vector3.zero;
        continue;
      }
      felt = next;
      lock (gate) {
        force = ToUnity(tick.Force);
        proxy = ToUnity(tick.XWG.P);
      }
    }
  }

  void Carve() {
    while (going) {
      bool worked;
      lock (coreGate) worked = core.Carve();
      if (!worked) Thread.Sleep(1);
    }
  }

  void Update() {
    lock (gate) {
      hand = transform.InverseTransformPoint(tool.position);
      shownTool.position = transform.TransformPoint(proxy);
    }
    Brick[] changed;
    lock (coreGate) changed = core.Mesh();
    foreach (var brick in changed) Show(brick);
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
    // Unity draws triangles that are clockwise as seen from outside; the library's triangles are counter-clockwise.
    for (int i = 0; i < brick.Triangles.Length; i += 3) {
      int second = brick.Triangles[i + 1];
      brick.Triangles[i + 1] = brick.Triangles[i + 2];
      brick.Triangles[i + 2] = second;
    }
    mesh.Clear();
    mesh.vertices = corners;
    mesh.normals = normals;
    mesh.triangles = brick.Triangles;
  }

  void OnDestroy() {
    going = false;
    if (servoThread != null) servoThread.Join();
    if (tissueThread != null) tissueThread.Join();
    if (servo != null) servo.Dispose();
    if (core != null) core.Dispose();
  }
}
#endif
