// Meshes of burs and probes: a surface of revolution with modelled flutes, and the shank.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

namespace typodont::render {

/// Shape of a cutting head. The origin of the tool frame is the head's centre; z points along the shank.
struct ToolShape {
  std::vector<glm::dvec2> profile;  // m, (radius, z) from the tip to the neck, with increasing z
  int flutes = 8;                   // number of flutes; 0: the head is smooth (a probe)
  double flute_depth = 0.15;        // depth of a flute as a fraction of the local radius
  double helix = 0.5;               // number of turns of a flute over the length of the head
  double neck_radius = 4e-4;        // m, radius of the neck
  double neck_length = 4e-3;        // m, length of the neck
  double shank_radius = 8e-4;       // m, radius of the shank; friction-grip shanks have a diameter of 1.6 mm
  double shank_length = 16e-3;      // m, length of the shank; 0: the tool has neither neck nor shank
  bool diamond = false;             // true: the head has rough diamond grit instead of flutes
  std::vector<double> marks;        // m, z of the dark depth marks around the head
  double thread_pitch = 0;          // m, pitch of the thread; 0: no thread
  double thread_core = 0;           // m, core radius of the thread
};

/// Predefined shapes: sphere, cylinder, round_end_cylinder, cone, pear, flame, inverted_cone. `length` is the length of
/// the head; a sphere ignores it. Throws Error for another name.
ToolShape tool_shape(std::string_view shape, double diameter, double length);
bool has_own_look(std::string_view shape) noexcept;
/// Returns a shape with another outline. `outline`: ToolShape::profile of the head alone, at least two points.
ToolShape outlined_shape(std::vector<glm::dvec2> outline);

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
