// Meshes of burs and probes: surfaces of revolution, with modelled flutes and threads.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace typodont::render {

/// A tool as surfaces of revolution about z. The origin is the head's centre; z points along the shank. An outline
/// consists of points (radius, z) in m, from the free end upwards.
struct ToolShape {
  std::vector<glm::dvec2> head;      // empty: the head is not drawn
  std::vector<glm::dvec2> safe_end;  // smooth pin beyond the free end; empty: none
  std::vector<glm::dvec2> shaft;     // neck and shank; empty: a handle replaces them
  int flutes = 8;                    // number of flutes; 0: the head is smooth (a probe)
  double flute_depth = 0.15;         // depth of a flute as a fraction of the local radius
  double helix = 0.5;                // number of turns of a flute over the length of the head
  bool diamond = false;              // true: the head has diamond grit instead of flutes
  std::vector<double> marks;         // m, z of the dark depth marks around the head
  double thread_pitch = 0;           // m, pitch of the thread; 0: no thread
  double thread_core = 0;            // m, core radius of the thread
};

/// Finish of the metal, as shaders/tool.frag reads it.
enum class Finish { kPolished = 0, kBrushed = 1, kGrit = 2 };

/// A vertex of the tool, and the same vertex on the hull. The hull is the shape that a fast rotating tool seems to
/// have. The renderer interpolates between both, depending on the spindle speed.
struct ToolVertex {
  glm::vec3 p{0}, n{0, 0, 1};            // position (m) and unit normal in the tool's frame
  glm::vec3 hull_p{0}, hull_n{0, 0, 1};  // position (m) and unit normal of the same vertex on the hull
  float spins = 1;                       // 1: the vertex rotates with the spindle
  float rough = 0.3f;
  float mark = 0;    // 1: the vertex is on a dark depth mark
  float finish = 0;  // finish of the metal at the vertex: a value of Finish
};
struct ToolMesh {
  std::vector<ToolVertex> vertices;
  std::vector<std::uint32_t> indices;
  int blades = 8;  // number of equal parts around the head, for the motion blur: flutes, or 1 for a thread
};

ToolMesh make_tool_mesh(const ToolShape& shape);

/// Returns the mesh of a suction tip's tube with its slanted opening, in frame S of contract/suction_tip.h. Lengths in
/// m, slant in rad.
ToolMesh make_suction_mesh(double opening, double wall, double slant, double length);

/// Adds a smooth, brushed surface of revolution about z, for a profile of (radius, z) in m from its lower end upwards.
void add_lathe(ToolMesh& mesh, const std::vector<glm::dvec2>& profile, int around, float rough);

}  // namespace typodont::render
