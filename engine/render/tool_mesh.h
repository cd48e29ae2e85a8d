// Burs and probes as surfaces of revolution, with flutes and threads.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::render {

/// About z; origin in the head's centre, z along the shank. Outlines: (radius, z), m, from the free end upwards.
struct ToolShape {
  std::vector<glm::dvec2> head;      // empty: the head is not drawn
  std::vector<glm::dvec2> safe_end;  // smooth pin beyond the free end; empty: none
  std::vector<glm::dvec2> shaft;     // neck and shank; empty: a handle replaces them
  int flutes = 8;                    // 0: smooth (a probe)
  double flute_depth = 0.15;         // of the local radius
  double helix = 0.5;                // turns over the head's length
  bool diamond = false;              // grit instead of flutes
  std::vector<double> marks;         // m, z of dark marks
  double thread_pitch = 0;           // m, pitch of the thread; 0: no thread
  double thread_core = 0;            // m, core radius of the thread
};

/// Of metal, for shaders/tool.frag.
enum class Finish { kPolished = 0, kBrushed = 1, kGrit = 2 };

/// And on the hull, which fast rotation seems to have; blended by the spindle speed.
struct ToolVertex {
  glm::vec3 p{0}, n{0, 0, 1};            // m, and unit normal
  glm::vec3 hull_p{0}, hull_n{0, 0, 1};  // the same on the hull
  float spins = 1;                       // 1: the vertex rotates with the spindle
  float rough = 0.3f;
  float mark = 0;    // 1: on a dark depth mark
  float finish = 0;  // a value of Finish
};
struct ToolMesh {
  std::vector<ToolVertex> vertices;
  std::vector<std::uint32_t> indices;
  int blades = 8;  // parts around the head, for motion blur: flutes, 1 for a thread
};

ToolMesh make_tool_mesh(const ToolShape& shape);

/// A tube with a slanted opening, frame S of contract/suction_tip.h. m, rad.
ToolMesh make_suction_mesh(double opening, double wall, double slant, double length);

/// Smooth and brushed; (radius, z), m, upwards.
void add_lathe(ToolMesh& mesh, const std::vector<glm::dvec2>& profile, int around, float rough);

}  // namespace typodont::render
