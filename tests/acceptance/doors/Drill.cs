// A turning bur goes down into a ball of enamel, in C#: prints the force on the hand and what was removed.
using System;
using Typodont;

static class Drill {
  const string Ball = @"{""tissue"": {""voxel_mm"": 0.1, ""solids"": [{""tissue"": ""enamel"", ""solid"": {""sphere"": {""radius_mm"": 3}}}]},
                         ""tool"": ""round_012"", ""spindle_krpm"": 300}";

  static void Main() {
    using (var scene = Scene.Parse(Ball))
    using (var core = new Core(scene)) {
      int triangles = 0;
      foreach (var brick in core.Mesh()) triangles += brick.Triangles.Length / 3;
      var hand = new Sample { Pedal = 1 };
      var tick = new Tick();
      double z = 3.7e-3;  // m
      for (int i = 1; i <= 2000; ++i) {
        if (i <= 1000) z -= 0.5e-6;
        hand.TNs = i * 1000000L;
        hand.XWT = new Pose(new Vector(0, 0, z));
        core.Step(ref hand, ref tick);
        if (i % 500 == 0) Console.WriteLine("{0:F1} s: {1:F3} N, {2:F4} mm3", i * 1e-3, tick.Force.Z, tick.Removed[1] * 1e9);
      }
      Console.WriteLine("{0} triangles, {1} bricks changed, undone {2}", triangles, core.Mesh().Length, core.Undo());
      try {
        hand.XWT.P.X = double.NaN;
        core.Step(ref hand, ref tick);
      } catch (TypodontException e) {
        Console.WriteLine("refused: {0}", e.Message);
      }
    }
  }
}
