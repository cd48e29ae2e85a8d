// The types of Unity that TypodontTooth.cs uses, with the smallest definitions that let a test run it without Unity.
// Written from Unity's public documentation; this is not Unity's code.
using System;
using System.Collections.Generic;

namespace UnityEngine {

public struct Vector3 {
  public float x, y, z;
  public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
  public static Vector3 zero { get { return new Vector3(); } }
  public static Vector3 operator+(Vector3 a, Vector3 b) { return new Vector3(a.x + b.x, a.y + b.y, a.z + b.z); }
  public static Vector3 operator-(Vector3 a, Vector3 b) { return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z); }
  public static Vector3 operator*(float s, Vector3 a) { return new Vector3(s * a.x, s * a.y, s * a.z); }
  public static float Dot(Vector3 a, Vector3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  public static Vector3 Cross(Vector3 a, Vector3 b) {
    return new Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  }
  public float magnitude { get { return (float)Math.Sqrt(Dot(this, this)); } }
}

public struct Vector3Int {
  public readonly int x, y, z;
  public Vector3Int(int x, int y, int z) { this.x = x; this.y = y; this.z = z; }
}

public class Transform {  // without rotation and scale
  public Vector3 position;
  public Transform parent;
  public Vector3 TransformPoint(Vector3 p) { return p + position; }
  public Vector3 InverseTransformPoint(Vector3 p) { return p - position; }
  public void SetParent(Transform p, bool worldPositionStays) { parent = p; }
}

public class Material {}

public class Mesh {
  Vector3[] vertices_ = new Vector3[0], normals_ = new Vector3[0];
  int[] triangles_ = new int[0];
  public int changes;
  public void MarkDynamic() {}
  public void Clear() { ++changes; }
  public Vector3[] vertices { get { return vertices_; } set { vertices_ = value; } }
  public Vector3[] normals { get { return normals_; } set { normals_ = value; } }
  public int[] triangles { get { return triangles_; } set { triangles_ = value; } }
}

public class Component {
  public Transform transform = new Transform();
}
public class MonoBehaviour : Component {}
public class MeshFilter : Component {
  public Mesh mesh = new Mesh();
}
public class MeshRenderer : Component {
  public Material material;
}

public class GameObject {
  public static readonly List<GameObject> All = new List<GameObject>();
  public readonly Transform transform = new Transform();
  readonly List<object> components = new List<object>();
  public GameObject(string name, params Type[] types) {
    foreach (var type in types) components.Add(Activator.CreateInstance(type));
    All.Add(this);
  }
  public T GetComponent<T>() { return (T)components.Find(c => c is T); }
}

}  // namespace UnityEngine
