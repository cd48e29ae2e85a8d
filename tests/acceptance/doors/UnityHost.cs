// Runs TypodontTooth as Unity would, over UnityDeclarations.cs: drills a ball, gives a bad pose, checks the meshes.
using System;
using System.Reflection;
using System.Threading;
using UnityEngine;

static class UnityHost {
  static void Require(bool holds, string claim) {
    if (holds) return;
    Console.WriteLine("not so: " + claim);
    Environment.Exit(1);
  }
  /// Unity calls these private methods by their names.
  static void Call(TypodontTooth tooth, string name) {
    typeof(TypodontTooth).GetMethod(name, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(tooth, null);
  }
  static int Changes(bool bricks) {
    int sum = 0;
    foreach (var part in GameObject.All) {
      int changes = part.GetComponent<MeshFilter>().mesh.changes;
      sum += bricks ? (changes > 1 ? 1 : 0) : changes;
    }
    return sum;
  }
  /// Every vertex lies in the ball of 3 mm, and every triangle of the undrilled ball faces outwards in Unity's axes.
  static void Check(bool whole) {
    foreach (var part in GameObject.All) {
      var mesh = part.GetComponent<MeshFilter>().mesh;
      Require(part.transform.parent != null && mesh.normals.Length == mesh.vertices.Length, "attached, with normals");
      foreach (var p in mesh.vertices)
        Require(p.magnitude < 3.1e-3f && (!whole || p.magnitude > 2.9e-3f), "radius in metres");
      for (int i = 0; whole && i < mesh.triangles.Length; i += 3) {
        Vector3 a = mesh.vertices[mesh.triangles[i]], b = mesh.vertices[mesh.triangles[i + 1]],
                c = mesh.vertices[mesh.triangles[i + 2]];
        Require(Vector3.Dot(Vector3.Cross(b - a, c - a), a) >= 0, "clockwise as seen from outside, in left-handed axes");
      }
    }
  }

  static void Main(string[] arguments) {
    var tooth = new TypodontTooth { scene = arguments[0], tool = new Transform(), shownTool = new Transform(), pedal = 1 };
    tooth.transform.position = new Vector3(1, 2, 3);
    float y = 4e-3f, largest = 0;  // m, above the ball's centre; N
    Action frame = () => {
      tooth.tool.position = tooth.transform.position + new Vector3(0.4e-3f, y, -0.6e-3f);
      Call(tooth, "Update");
      largest = Math.Max(largest, tooth.force.y);
      Thread.Sleep(16);
    };
    tooth.tool.position = tooth.transform.position + new Vector3(0, y, 0);
    Call(tooth, "Start");
    while (Changes(false) == 0) frame();
    int bricks = GameObject.All.Count, first = Changes(false);
    Require(first == bricks, "the first frame makes each brick once");
    Check(true);
    while (y > 2.6e-3f && (y > 3.2e-3f || largest < 0.1f)) {
      y -= 25e-6f;
      frame();
    }
    Check(false);
    Require(largest > 0.1f, "the force points out of the tissue, along Unity's y axis");
    Require(Changes(true) < bricks / 2, "drilling leaves most bricks as they are");
    Require(tooth.shownTool.position.y >= tooth.tool.position.y - 1e-6f, "the shown tool is not deeper than the hand");
    var sum = new Vector3();
    int count = 0;
    foreach (var part in GameObject.All)
      foreach (var p in part.GetComponent<MeshFilter>().mesh.vertices)
        if (p.magnitude < 2.98e-3f) { sum += p; ++count; }
    Require(count > 0 && Math.Abs(sum.x / count - 0.4e-3f) < 0.2e-3f && Math.Abs(sum.z / count + 0.6e-3f) < 0.2e-3f,
            "the pit is where the hand was");
    y = float.NaN;
    for (frame(); tooth.force.y != 0;) frame();
    y = 2.9e-3f;
    while (tooth.force.y == 0) frame();
    Call(tooth, "OnDestroy");
    Console.WriteLine("{0} bricks, of which {1} changed, {2:F3} N at most", bricks, Changes(true), largest);
  }
}
