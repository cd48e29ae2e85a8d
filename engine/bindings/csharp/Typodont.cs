// Typodont for C#: P/Invoke declarations of libtypodont.so, and classes that use them. typodont.h describes the
// functions.
using System;
using System.Runtime.InteropServices;

namespace Typodont {

/// A call failed. The message gives the reason.
public class TypodontException : Exception {
  public TypodontException(string message) : base(message) {}
}

[StructLayout(LayoutKind.Sequential)]
public struct Vector {
  public double X, Y, Z;
  public Vector(double x, double y, double z) { X = x; Y = y; Z = z; }
}

/// A position in metres and a unit quaternion.
[StructLayout(LayoutKind.Sequential)]
public struct Pose {
  public Vector P;
  public double Qw, Qx, Qy, Qz;
  public Pose(Vector p) { P = p; Qw = 1; Qx = Qy = Qz = 0; }
}

/// The input of one tick: the hand's pose and pedal.
[StructLayout(LayoutKind.Sequential)]
public struct Sample {
  public uint StructSize, Tool;
  public long TNs;
  public Pose XWT;
  public double Pedal;
}

/// The result of one tick of the servo. SI units.
[StructLayout(LayoutKind.Sequential)]
public struct Tick {
  public uint StructSize, Faults;
  public ulong Index;
  public long TNs;
  public Pose XWT, XWG;
  public Vector Force, Torque;
  public double Pedal, Depth;
  public Vector Normal;
  public double ContactArea;
  [MarshalAs(UnmanagedType.ByValArray, SizeConst = 16)] public double[] Removed;
  public double Spindle, CuttingPower, Energy, SpindleEnergy;
  public Vector ModelForce;
  public ulong Cuts;
  public long CpuNs;
  public uint Tissue, TakenTool, Level, Patch;
  public double Wear;
}

/// A vertex of the surface in metres, in the layout of a vertex buffer.
[StructLayout(LayoutKind.Sequential)]
public struct Vertex {
  public float X, Y, Z, Nx, Ny, Nz;
  public byte Tissue0, Tissue1, Second, Reserved;
}

[StructLayout(LayoutKind.Sequential)]
public struct MeshPart {
  public int BrickX, BrickY, BrickZ;
  public uint VertexCount, IndexCount, Reserved;
  public IntPtr Vertices, Indices;
}

/// The triangles of one brick. Without triangles, the brick no longer contains a surface.
public class Brick {
  public int X, Y, Z;
  public Vertex[] Vertices;
  public int[] Triangles;
}

internal static class Native {
  const string Library = "typodont";

  [DllImport(Library)] internal static extern IntPtr typodont_version();
  [DllImport(Library)] internal static extern IntPtr typodont_error();
  [DllImport(Library)] internal static extern int typodont_scene_open(byte[] scene, byte[] model, out IntPtr handle);
  [DllImport(Library)]
  internal static extern int typodont_scene_parse(byte[] json, byte[] folder, byte[] model, out IntPtr handle);
  [DllImport(Library)] internal static extern int typodont_scene_free(IntPtr scene);
  [DllImport(Library)]
  internal static extern int typodont_core_new(IntPtr scene, IntPtr hand, IntPtr options, out IntPtr handle);
  [DllImport(Library)] internal static extern int typodont_core_free(IntPtr core);
  [DllImport(Library)]
  internal static extern int typodont_core_tick(IntPtr core, ref Sample sample, ref Tick tick, IntPtr cut);
  [DllImport(Library)] internal static extern int typodont_core_servo(IntPtr core, double[] start, out IntPtr servo);
  [DllImport(Library)]
  internal static extern int typodont_servo_tick(IntPtr servo, ref Sample sample, ref Tick tick, IntPtr cut);
  [DllImport(Library)] internal static extern int typodont_core_carve(IntPtr core, out int worked);
  [DllImport(Library)] internal static extern int typodont_servo_free(IntPtr servo);
  [DllImport(Library)] internal static extern int typodont_core_undo(IntPtr core, out int done);
  [DllImport(Library)] internal static extern int typodont_core_redo(IntPtr core, out int done);
  [DllImport(Library)]
  internal static extern int typodont_core_mesh(IntPtr core, out IntPtr parts, out UIntPtr count);

  internal static void Check(int result) {
    if (result != 0) throw new TypodontException(Marshal.PtrToStringAnsi(typodont_error()));
  }
  internal static byte[] Utf8(string text) {
    return text == null ? null : System.Text.Encoding.UTF8.GetBytes(text + "\0");
  }
}

public static class Library {
  public static string Version { get { return Marshal.PtrToStringAnsi(Native.typodont_version()); } }
}

/// A scene: the tissue and the tools.
public sealed class Scene : IDisposable {
  internal IntPtr Handle;
  Scene(IntPtr handle) { Handle = handle; }

  /// Opens a scene file, or a shipped scene by name.
  public static Scene Open(string scene, string model = null) {
    IntPtr handle;
    Native.Check(Native.typodont_scene_open(Native.Utf8(scene), Native.Utf8(model), out handle));
    return new Scene(handle);
  }
  public static Scene Parse(string json, string folder = null, string model = null) {
    IntPtr handle;
    Native.Check(
        Native.typodont_scene_parse(Native.Utf8(json), Native.Utf8(folder), Native.Utf8(model), out handle));
    return new Scene(handle);
  }
  public void Dispose() {
    Native.Check(Native.typodont_scene_free(Handle));
    Handle = IntPtr.Zero;
  }
}

/// The servo and the tissue on one thread. After GiveServo, only the tissue.
public sealed class Core : IDisposable {
  IntPtr handle;

  public Core(Scene scene) {
    Native.Check(Native.typodont_core_new(scene.Handle, IntPtr.Zero, IntPtr.Zero, out handle));
  }
  /// Computes one tick and writes the result to `tick`.
  public void Step(ref Sample sample, ref Tick tick) {
    sample.StructSize = (uint)Marshal.SizeOf(typeof(Sample));
    tick.StructSize = (uint)Marshal.SizeOf(typeof(Tick));
    Native.Check(Native.typodont_core_tick(handle, ref sample, ref tick, IntPtr.Zero));
  }
  /// Splits off the servo for a thread of its own; call this before the first tick. Afterwards this thread calls Carve
  /// every few milliseconds.
  public Servo GiveServo(Vector start) {
    IntPtr servo;
    Native.Check(Native.typodont_core_servo(handle, new[] { start.X, start.Y, start.Z }, out servo));
    return new Servo(servo);
  }
  public bool Carve() {
    int worked;
    Native.Check(Native.typodont_core_carve(handle, out worked));
    return worked != 0;
  }
  public bool Undo() {
    int done;
    Native.Check(Native.typodont_core_undo(handle, out done));
    return done != 0;
  }
  public bool Redo() {
    int done;
    Native.Check(Native.typodont_core_redo(handle, out done));
    return done != 0;
  }
  /// The first call returns all bricks of the surface, each later call the bricks that changed.
  public Brick[] Mesh() {
    IntPtr parts;
    UIntPtr count;
    Native.Check(Native.typodont_core_mesh(handle, out parts, out count));
    var bricks = new Brick[(int)count];
    for (int i = 0; i < bricks.Length; ++i) {
      var part = (MeshPart)Marshal.PtrToStructure(
          new IntPtr(parts.ToInt64() + i * Marshal.SizeOf(typeof(MeshPart))), typeof(MeshPart));
      var brick = new Brick { X = part.BrickX, Y = part.BrickY, Z = part.BrickZ,
                              Vertices = new Vertex[part.VertexCount], Triangles = new int[part.IndexCount] };
      for (int v = 0; v < brick.Vertices.Length; ++v)
        brick.Vertices[v] = (Vertex)Marshal.PtrToStructure(
            new IntPtr(part.Vertices.ToInt64() + v * Marshal.SizeOf(typeof(Vertex))), typeof(Vertex));
      if (brick.Triangles.Length > 0) Marshal.Copy(part.Indices, brick.Triangles, 0, brick.Triangles.Length);
      bricks[i] = brick;
    }
    return bricks;
  }
  public void Dispose() {
    Native.Check(Native.typodont_core_free(handle));
    handle = IntPtr.Zero;
  }
}

/// The servo, for a thread of its own.
public sealed class Servo : IDisposable {
  IntPtr handle;
  internal Servo(IntPtr servo) { handle = servo; }
  public void Step(ref Sample sample, ref Tick tick) {
    sample.StructSize = (uint)Marshal.SizeOf(typeof(Sample));
    tick.StructSize = (uint)Marshal.SizeOf(typeof(Tick));
    Native.Check(Native.typodont_servo_tick(handle, ref sample, ref tick, IntPtr.Zero));
  }
  public void Dispose() {
    Native.Check(Native.typodont_servo_free(handle));
    handle = IntPtr.Zero;
  }
}

}  // namespace Typodont
