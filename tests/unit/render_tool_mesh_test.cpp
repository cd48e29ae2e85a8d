#include <gtest/gtest.h>

#include <map>

#include "engine/base/error.h"
#include "engine/render/tool_mesh.h"

namespace typodont::render {
namespace {

constexpr const char* kShapes[] = {"sphere", "cylinder", "round_end_cylinder", "cone",
                                   "pear",   "flame",    "inverted_cone"};

TEST(ToolMesh, EveryShapeStaysWithinItsDiameter) {
  for (const char* shape : kShapes) {
    const ToolMesh mesh = make_tool_mesh(tool_shape(shape, 1.2e-3, 4e-3));
    double widest = 0, head = 0;
    for (const ToolVertex& v : mesh.vertices) {
      const double r = glm::length(glm::dvec2(v.hull_p));
      if (v.hull_p.z < 2e-3f) head = std::max(head, r);
      widest = std::max(widest, r);
      // Flutes are cut into the hull and never project from it.
      EXPECT_LE(glm::length(glm::dvec2(v.p)), r + 1e-9) << shape;
    }
    EXPECT_NEAR(head, 0.6e-3, 0.04e-3) << shape;
    EXPECT_NEAR(widest, 0.8e-3, 1e-6) << shape;  // the shank
  }
}

TEST(ToolMesh, TrianglesFaceOutwards) {
  for (const char* shape : kShapes) {
    const ToolMesh mesh = make_tool_mesh(tool_shape(shape, 1.2e-3, 4e-3));
    // The signed volume of the hull is positive if its triangles run counter-clockwise when seen from outside.
    double volume = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const glm::dvec3 a(mesh.vertices[mesh.indices[i]].hull_p), b(mesh.vertices[mesh.indices[i + 1]].hull_p),
          c(mesh.vertices[mesh.indices[i + 2]].hull_p);
      volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    EXPECT_GT(volume, 1e-9 * 10) << shape;
  }
}

TEST(ToolMesh, AShapeWithoutItsOwnMeshIsDrawnFromItsOutline) {
  const ToolMesh mesh = make_tool_mesh(outlined_shape({{0, -1e-3}, {0.5e-3, 0}, {0.6e-3, 1e-3}}));
  double head = 0;
  for (const ToolVertex& v : mesh.vertices) {
    if (v.hull_p.z > 1.001e-3f) continue;
    const double r = glm::length(glm::dvec2(v.hull_p)), z = v.hull_p.z;
    EXPECT_NEAR(r, z < 0 ? 0.5e-3 * (1 + z / 1e-3) : 0.5e-3 + 0.1e-3 * z / 1e-3, 1e-9) << z;
    head = std::max(head, r);
  }
  EXPECT_NEAR(head, 0.6e-3, 1e-9);
}

TEST(ToolMesh, AnUnknownShapeIsAnError) {
  for (const char* shape : kShapes) EXPECT_TRUE(has_own_look(shape)) << shape;
  EXPECT_FALSE(has_own_look("spere"));
  EXPECT_THROW((void)tool_shape("spere", 1e-3, 2e-3), Error);
}

}  // namespace
}  // namespace typodont::render
