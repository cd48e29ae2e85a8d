// Meshes of burs and probes: surfaces of revolution with flutes and threads.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::render {

/// Shape of a tool about z; origin in the head's centre, z along the shank. Outlines are points (radius, z) in m, from
/// the free end upwards.
struct ToolShape {
  std::vector<glm::dvec2> head;      // outline of the head; empty: the head is not drawn
  std::vector<glm::dvec2> safe_end;  // outline of the smooth pin beyond the free end; empty: none
  std::vector<glm::dvec2> shaft;     // neck and shank; empty: replaced by a handle
  int flutes = 8;                    // number of flutes; 0: smooth (a probe)
  double flute_depth = 0.15;         // depth of a flute as a fraction of the local radius
  double helix = 0.5;                // turns of the flutes over the head's length
  bool diamond = false;              // true: the head has diamond grit instead of flutes
  std::vector<double> marks;         // m, z of dark depth marks
  double thread_pitch = 0;           // m, pitch of the thread; 0: no thread
  double thread_core = 0;            // m, core radius of the thread
};

/// Surface of metal, for shaders/tool.frag.
enum class Finish { kPolished = 0, kBrushed = 1, kGrit = 2 };

/// Vertex of a tool, and its position on the hull, the shape that the tool seems to have in fast rotation. The shader
/// blends both positions according to the spindle speed.
struct ToolVertex {
  glm::vec3 p{0}, n{0, 0, 1};            // position (m) and unit normal on the tool
  glm::vec3 hull_p{0}, hull_n{0, 0, 1};  // position (m) and unit normal on the hull
  float spins = 1;                       // 1: the vertex rotates with the spindle; 0: it doesn't
  float rough = 0.3f;
  float mark = 0;    // 1: the vertex is on a dark depth mark; 0: it isn't
  float finish = 0;  // a value of Finish
};
struct ToolMesh {
  std::vector<ToolVertex> vertices;
  std::vector<std::uint32_t> indices;
  int blades = 8;  // number of equal parts around the head, for motion blur: number of flutes; 1 for a thread
};

ToolMesh make_tool_mesh(const ToolShape& shape);

/// Mesh of a tube with slanted opening, in the frame S of contract/suction_tip.h. Lengths in m, angle in rad.
ToolMesh make_suction_mesh(double opening, double wall, double slant, double length);

/// Adds a smooth, brushed surface of revolution; profile (radius, z), m, upwards.
void add_lathe(ToolMesh& mesh, const std::vector<glm::dvec2>& profile, int around, float rough);

}  // namespace typodont::render
