#include "haptics/solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/base/in_parallel.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr Range kSolidLength{1e-3, 1e6, kMillimetre}, kHalfSolidLength{1e-3, 1e6, kMillimetre / 2};

struct Sphere : Solid {
  dvec3 center{0};
  double radius;
  double distance(const dvec3& p) const override { return glm::length(p - center) - radius; }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = center - radius, hi = center + radius; }
};

struct Halfspace : Solid {
  dvec3 normal;
  double offset;
  double distance(const dvec3& p) const override { return glm::dot(normal, p) - offset; }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = dvec3(-kInfinity), hi = dvec3(kInfinity); }
};

struct Box : Solid {
  dvec3 center{0}, half;
  double distance(const dvec3& p) const override {
    const dvec3 q = glm::abs(p - center) - half;
    return glm::length(glm::max(q, 0.0)) + std::min(std::max({q.x, q.y, q.z}), 0.0);
  }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = center - half, hi = center + half; }
};

struct Cylinder : Solid {
  dvec3 center{0}, axis{0, 0, 1};
  double radius, half;
  double distance(const dvec3& p) const override {
    const dvec3 d = p - center;
    const double z = glm::dot(d, axis);
    const glm::dvec2 q(glm::length(d - z * axis) - radius, std::abs(z) - half);
    return glm::length(glm::max(q, 0.0)) + std::min(std::max(q.x, q.y), 0.0);
  }
  void bounds(dvec3& lo, dvec3& hi) const override {
    const dvec3 extent = glm::abs(axis) * half + radius * glm::sqrt(glm::max(1.0 - axis * axis, 0.0));
    lo = center - extent, hi = center + extent;
  }
};

/// A truncated cone, or a cone with a tip. The distance is computed in the half plane through the axis.
struct Cone : Solid {
  dvec3 center{0}, axis{0, 0, 1};
  // Radii at the heights -half and +half, and half of the height, m.
  double radius, top_radius = 0, half;

  double distance(const dvec3& p) const override {
    const dvec3 d = p - center;
    const double z = glm::dot(d, axis);
    const glm::dvec2 q(glm::length(d - z * axis), z), corner(radius, -half), side(top_radius - radius, 2 * half);
    // Computes the distances to the two end discs and to the slanted side.
    const double below = glm::length(glm::dvec2(std::max(q.x - radius, 0.0), q.y + half));
    const double above = glm::length(glm::dvec2(std::max(q.x - top_radius, 0.0), q.y - half));
    const double s = std::clamp(glm::dot(q - corner, side) / glm::dot(side, side), 0.0, 1.0);
    const double nearest = std::min({below, above, glm::length(q - corner - s * side)});
    // Positive if the point is on the outer side of the slanted line.
    const double out = side.y * (q.x - corner.x) - side.x * (q.y - corner.y);
    return std::abs(z) < half && out < 0 ? -nearest : nearest;
  }
  void bounds(dvec3& lo, dvec3& hi) const override {
    const dvec3 wide = glm::sqrt(glm::max(1.0 - axis * axis, 0.0)), a = center - half * axis, b = center + half * axis;
    lo = glm::min(a - radius * wide, b - top_radius * wide), hi = glm::max(a + radius * wide, b + top_radius * wide);
  }
};

struct Capsule : Solid {
  dvec3 a, b;
  double radius;
  double distance(const dvec3& p) const override {
    const dvec3 ab = b - a;
    const double length2 = glm::dot(ab, ab);
    const double s = length2 > 0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p - a - s * ab) - radius;
  }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = glm::min(a, b) - radius, hi = glm::max(a, b) + radius; }
};

struct Torus : Solid {
  dvec3 center{0}, axis{0, 0, 1};
  double major, minor;
  double distance(const dvec3& p) const override {
    const dvec3 d = p - center;
    const double z = glm::dot(d, axis);
    return std::hypot(glm::length(d - z * axis) - major, z) - minor;
  }
  void bounds(dvec3& lo, dvec3& hi) const override {
    const dvec3 extent = major * glm::sqrt(glm::max(1.0 - axis * axis, 0.0)) + minor;
    lo = center - extent, hi = center + extent;
  }
};

enum class Operation { kUnion, kIntersection, kDifference };

struct Combination : Solid {
  Operation operation;
  std::vector<std::unique_ptr<Solid>> parts;

  double distance(const dvec3& p) const override {
    double d = parts[0]->distance(p);
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const double other = parts[i]->distance(p);
      if (operation == Operation::kUnion) d = std::min(d, other);
      if (operation == Operation::kIntersection) d = std::max(d, other);
      if (operation == Operation::kDifference) d = std::max(d, -other);
    }
    return d;
  }
  void bounds(dvec3& lo, dvec3& hi) const override {
    parts[0]->bounds(lo, hi);
    if (operation == Operation::kDifference) return;
    for (std::size_t i = 1; i < parts.size(); ++i) {
      dvec3 l, h;
      parts[i]->bounds(l, h);
      lo = operation == Operation::kUnion ? glm::min(lo, l) : glm::max(lo, l);
      hi = operation == Operation::kUnion ? glm::max(hi, h) : glm::min(hi, h);
    }
  }
};

void describe_solid_axis(Keys& keys, dvec3& center, dvec3& axis) {
  keys("center_mm", center, kMillimetre, "centre");
  keys("axis", axis, read_direction, "axis; default [0, 0, 1]");
}

/// Declares the keys of a solid. Without `files.read_mesh`, a mesh is an error.
void describe_solid(Keys& keys, std::unique_ptr<Solid>& solid, const SolidFiles& files) {
  const auto primitive = [&]<class T>(const char* name, const char* meaning, T value, auto describe) {
    keys.alternative();
    const auto of = [&](Keys& its) { describe(its, value); };
    if (const auto json = keys(must(name), kObject, of, meaning)) {
      read_keys(*json, of);
      solid = std::make_unique<T>(value);
    }
  };
  const auto combination = [&](const char* name, Operation operation, std::string_view meaning) {
    keys.alternative();
    if (const auto json = keys(must(name), kSolids, meaning)) {
      auto made = std::make_unique<Combination>();
      made->operation = operation;
      made->parts = read_solid_list(json->items(), files);
      if (made->parts.empty()) json->fail("at least one solid");
      solid = std::move(made);
    }
  };
  primitive("sphere", "sphere", Sphere(), [](Keys& of, Sphere& s) {
    of("center_mm", s.center, kMillimetre, "centre");
    of(must("radius_mm"), s.radius, kSolidLength, "radius");
  });
  primitive("halfspace", "half space", Halfspace(), [](Keys& of, Halfspace& s) {
    of(must("normal"), s.normal, read_direction, "outward direction n");
    of(must("offset_mm"), s.offset, {.unit = kMillimetre}, "solid where n·p < offset");
  });
  primitive("box", "box along the axes", Box(), [](Keys& of, Box& s) {
    of("center_mm", s.center, kMillimetre, "centre");
    of(must("size_mm"), s.half, kMillimetre / 2, "edge lengths");
    if (const Json* json = of.json(); json && !(std::min({s.half.x, s.half.y, s.half.z}) > 0))
      (*json)["size_mm"].fail("three lengths above 0");
  });
  primitive("cylinder", "cylinder", Cylinder(), [](Keys& of, Cylinder& s) {
    describe_solid_axis(of, s.center, s.axis);
    of(must("radius_mm"), s.radius, kSolidLength, "radius");
    of(must("height_mm"), s.half, kHalfSolidLength, "height");
  });
  primitive("cone", "cone", Cone(), [](Keys& of, Cone& s) {
    describe_solid_axis(of, s.center, s.axis);
    of(must("radius_mm"), s.radius, kSolidLength, "radius at the lower end");
    of("top_radius_mm", s.top_radius, {0, 1e6, kMillimetre}, "radius at the upper end, to which the axis points");
    of(must("height_mm"), s.half, kHalfSolidLength, "height");
  });
  primitive("capsule", "cylinder with round ends", Capsule(), [](Keys& of, Capsule& s) {
    of(must("a_mm"), s.a, kMillimetre, "one end of the axis");
    of(must("b_mm"), s.b, kMillimetre, "the other end");
    of(must("radius_mm"), s.radius, kSolidLength, "radius");
  });
  primitive("torus", "torus", Torus(), [](Keys& of, Torus& s) {
    describe_solid_axis(of, s.center, s.axis);
    of(must("major_mm"), s.major, kSolidLength, "radius of the centre line");
    of(must("minor_mm"), s.minor, kSolidLength, "radius of the tube; smaller than `major_mm`");
    if (of.json() && s.minor >= s.major) (*of.json())["minor_mm"].fail("less than major_mm");
  });
  keys.alternative();
  keys(
      must("mesh"),
      [&](Keys& of) {
        const auto name = of(must("file"), kFile, "STL, PLY, OBJ or glTF");
        double unit = kMillimetre;
        of("scale", unit, {1e-6, 1e6, kMillimetre}, "length of one unit of the file in millimetres");
        if (!name) return;
        if (!files.read_mesh) of.json()->fail("\"mesh\"", "a solid without a mesh: this program reads no mesh files");
        solid = files.read_mesh(files.find ? files.find(*name) : name->file().parent_path() / name->string(), unit);
      },
      "closed mesh");
  combination("union", Operation::kUnion, "all solids together");
  combination("intersection", Operation::kIntersection, "the common region");
  combination("difference", Operation::kDifference, "the first solid without the others");
}

}  // namespace

SolidFiles unread_meshes() {
  return {.find = {}, .read_mesh = [](const auto&, double) { return nullptr; }};
}

std::vector<Json> mesh_files(const Json& json) {
  std::vector<Json> files;
  const auto take = [&](const Json& from) {
    for (Json& file : mesh_files(from)) files.push_back(std::move(file));
  };
  if (json.is_object()) {
    for (const std::string& key : json.keys()) {
      if (key == "mesh")
        files.push_back(json[key]["file"]);
      else if (key == "solids" || key == "solid" || key == "union" || key == "intersection" || key == "difference")
        take(json[key]);
    }
  } else {
    for (const Json& item : json.items()) take(item);
  }
  return files;
}

std::unique_ptr<Solid> capsule(const dvec3& a_W, const dvec3& b_W, double radius) {
  auto s = std::make_unique<Capsule>();
  s->a = a_W, s->b = b_W, s->radius = radius;
  return s;
}

std::vector<std::unique_ptr<Solid>> read_solid_list(const std::vector<Json>& list, const SolidFiles& files) {
  std::vector<std::unique_ptr<Solid>> solids;
  for (const Json& item : list) solids.push_back(read_solid(item, files));
  return solids;
}

std::unique_ptr<Solid> read_solid(const Json& json, const SolidFiles& files) {
  std::unique_ptr<Solid> solid;
  read_keys(json, [&](Keys& keys) { describe_solid(keys, solid, files); });
  return solid;
}

void list_solid(Keys& keys) {
  std::unique_ptr<Solid> solid;
  describe_solid(keys, solid, {});
}

namespace {

constexpr double kHalfVoxel = 0.87;  // voxels, upper bound of the distance from a voxel's centre to its corners
// Voxels. Surfaces that are closer than this count as one surface, which belongs to the later solid.
constexpr double kTies = 1e-6;

/// Returns the point inside a voxel at which its label is determined, relative to the centre, in voxels. Evenly
/// distributed points (sequence R2, Roberts 2018) make the number of voxels of each tissue proportional to its volume.
dvec3 place_within(const glm::ivec3& voxel) {
  constexpr double a = 0.7548776662466927, b = 0.5698402909980532, along = 0.5497004779019703;
  const dvec3 v(voxel);
  return glm::fract(a * dvec3(v.y, v.z, v.x) + b * dvec3(v.z, v.x, v.y) + along * v) - 0.5;
}

/// Returns the last part (a solid with its label) that contains the point, or null if no part contains it.
const LabelledSolid* part_inside(const std::vector<const LabelledSolid*>& near, const dvec3& p) {
  for (auto part = near.rbegin(); part != near.rend(); ++part) {
    if ((*part)->solid->distance(p) <= 0) return *part;
  }
  return nullptr;
}

/// Returns the part that contains the centre of `voxel`, or else the nearest part within three voxels. `distances`: for
/// each part, the distances of all voxels of the block, m. `h`: edge of a voxel, m.
const LabelledSolid* part_around(const std::vector<const LabelledSolid*>& near,
                                 const std::vector<std::vector<double>>& distances, std::size_t voxel, double h) {
  for (std::size_t k = near.size(); k-- > 0;) {
    if (distances[k][voxel] <= 0) return near[k];
  }
  double nearest = 3 * h;
  const LabelledSolid* found = nullptr;
  for (std::size_t k = 0; k < near.size(); ++k) {
    const double own = distances[k][voxel];
    if (own >= std::min(nearest + kTies * h, 3 * h)) continue;
    nearest = std::min(nearest, own);
    found = near[k];
  }
  return found;
}

}  // namespace

void voxels_of_block(const glm::ivec3& first, const glm::ivec3& end, std::vector<glm::ivec3>& voxels) {
  voxels.clear();
  const glm::ivec3 size = end - first;
  for (int a = 0; a < size.x; ++a) {
    for (int b = 0; b < size.y; ++b) {
      const int row = a * size.y + b;
      for (int c = 0; c < size.z; ++c)
        voxels.push_back(first + glm::ivec3(a, a % 2 == 0 ? b : size.y - 1 - b, row % 2 == 0 ? c : size.z - 1 - c));
    }
  }
}

Tissue read_tissue_name(const Json& json, std::string_view expected) {
  const auto tissue = tissue_named(json.string());
  if (!tissue || *tissue == Tissue::kAir) json.fail(expected);
  return *tissue;
}

void describe_labelled_solid(Keys& keys, LabelledSolid& labelled, const SolidFiles& files) {
  if (const auto name = keys(must("tissue"), kName, "label")) labelled.tissue = read_tissue_name(*name);
  if (const auto json = keys(must("solid"), kSolid, "region of the label")) labelled.solid = read_solid(*json, files);
  double hardness = 1;
  keys("hardness", hardness, {0, 1}, "[hardness](#hardness)");
  labelled.hardness = hardness_byte(hardness);
  dvec3 color(kNoDefault);
  keys("color", color, read_color, "[colour](#color); default: the tissue's");
  if (is_finite(color)) labelled.color = voxel_color(color);
}

void read_box(const Json& json, dvec3& lo, dvec3& hi) {
  const auto corners = json.items();
  if (corners.size() != 2) json.fail("two corners [[x0,y0,z0],[x1,y1,z1]]");
  lo = corners[0].vec3() * kMillimetre;
  hi = corners[1].vec3() * kMillimetre;
  if (!(lo.x < hi.x && lo.y < hi.y && lo.z < hi.z)) json.fail("a lower corner below the upper one");
}

namespace {

struct SolidTissue {
  double voxel = 0.1 * kMillimetre, band = 1.5 * kMillimetre;
  dvec3 lo{kInfinity}, hi{-kInfinity};  // m, frame W, corners of the tissue's region
  std::vector<LabelledSolid> parts;
};

void describe_solid_tissue(Keys& keys, SolidTissue& tissue, const SolidFiles& files) {
  const Json* json = keys.json();
  const auto part = [&](Keys& of, LabelledSolid& labelled) { describe_labelled_solid(of, labelled, files); };
  keys(must("solids"), tissue.parts, part, "where solids overlap, the later one counts");
  if (json && tissue.parts.empty()) (*json)["solids"].fail("at least one solid");
  keys(must("voxel_mm"), tissue.voxel, {0.01, 5, kMillimetre},
       "size of a voxel. The volume may have at most 600 million voxels");
  keys("band_mm", tissue.band, {0.01, 50, kMillimetre},
       "distance from the surface up to which the volume stores distances, at least three voxels");
  if (json && tissue.band < 3 * tissue.voxel)
    json->fail(fmt::format("band_mm {}", tissue.band / kMillimetre), "at least three voxels");
  if (const auto domain =
          keys("domain_mm", kBox,
               "region of the tissue. Default: the bounding box of the solids, enlarged by `band_mm`. Required if a "
               "solid is unbounded (a half space)"))
    read_box(*domain, tissue.lo, tissue.hi);
}

}  // namespace

void describe_solid_tissue(Keys& keys) {
  SolidTissue tissue;
  describe_solid_tissue(keys, tissue, unread_meshes());
}

DenseTissue read_solids(const Json& json, const SolidFiles& files) {
  SolidTissue tissue;
  read_keys(json, [&](Keys& keys) { describe_solid_tissue(keys, tissue, files); });
  const std::vector<LabelledSolid>& parts = tissue.parts;
  const double h = tissue.voxel;
  DenseTissue dense;
  dense.band = tissue.band;
  dvec3 &lo = tissue.lo, &hi = tissue.hi;
  if (!json.has("domain_mm")) {
    for (const LabelledSolid& part : parts) {
      dvec3 l, h2;
      part.solid->bounds(l, h2);
      lo = glm::min(lo, l);
      hi = glm::max(hi, h2);
    }
    if (!std::isfinite(glm::length(lo)) || !std::isfinite(glm::length(hi))) {
      json["solids"].fail("an unbounded solid", "\"domain_mm\" beside \"voxel_mm\"");
    }
    lo -= dense.band;
    hi += dense.band;
  }
  // Voxel centres are multiples of h, so that the samples of a solid do not depend on the bounds of the grid.
  const dvec3 first = glm::floor(lo / h), last = glm::ceil(hi / h);
  const dvec3 size = last - first + 1.0;
  constexpr double kMaxVoxels = 6e8;
  if (size.x * size.y * size.z > kMaxVoxels) {
    json["voxel_mm"].fail(fmt::format("{:.3g} voxels", size.x * size.y * size.z),
                          fmt::format("at most {:.0g}: a larger voxel or a smaller domain", kMaxVoxels));
  }
  dense.frame = {first * h, h};
  dense.size = glm::ivec3(size);
  const std::size_t count = static_cast<std::size_t>(dense.size.x) * dense.size.y * dense.size.z;
  dense.distance.resize(count);
  dense.tissue.resize(count);
  if (std::ranges::any_of(parts, [](const LabelledSolid& part) { return part.hardness != kOwnHardness; }))
    dense.hardness.assign(count, kOwnHardness);
  if (std::ranges::any_of(parts, [](const LabelledSolid& part) { return part.color != kTissueColor; }))
    dense.color.assign(count, kTissueColor);

  // Samples the solids block by block. The distance at a block's centre shows whether a solid can be near: inside a
  // block, a solid's distance differs from its value at the centre by at most half the block's diagonal (`reach`).
  constexpr int kBlock = 8;
  const double reach = 0.5 * std::sqrt(3.0) * (kBlock - 1) * h;
  const auto label = [&](std::size_t i, const LabelledSolid* part) {
    dense.tissue[i] = part ? part->tissue : Tissue::kAir;
    if (part && !dense.hardness.empty()) dense.hardness[i] = part->hardness;
    if (part && !dense.color.empty()) dense.color[i] = part->color;
  };
  struct Scratch {
    std::vector<const LabelledSolid*> near;
    std::vector<glm::ivec3> voxels;
    std::vector<dvec3> centres;                  // m, frame W, centres of the block's voxels
    std::vector<std::vector<double>> distances;  // m, for each part in `near`: distances of the block's voxels
  };
  const auto block = [&](const glm::ivec3& from, Scratch& scratch) {
    auto& near = scratch.near;
    const glm::ivec3 end = glm::min(from + kBlock, dense.size);
    const dvec3 middle = dense.frame.to_world(dvec3(from) + 0.5 * (kBlock - 1));
    near.clear();
    const LabelledSolid* deep = nullptr;
    // crossed: a border between two labels passes through the block. covered: one solid contains the whole block,
    // so deep that no distance must be stored (dense.band).
    bool crossed = false, covered = false;
    for (const LabelledSolid& part : parts) {
      const double own = part.solid->distance(middle);
      if (own - reach >= dense.band) continue;
      near.push_back(&part);
      covered = covered || own + reach <= -dense.band;
      if (own + reach + kHalfVoxel * h <= 0) {
        deep = &part;
      } else if (own - reach - kHalfVoxel * h <= 0) {
        crossed = true;
      }
    }
    voxels_of_block(from, end, scratch.voxels);
    if (near.empty() || (covered && !crossed)) {
      const auto clamped = static_cast<float>(near.empty() ? dense.band : -dense.band);
      for (const glm::ivec3& v : scratch.voxels) {
        const std::size_t i = dense.at(v.x, v.y, v.z);
        dense.distance[i] = clamped;
        label(i, deep);
      }
      return;
    }
    scratch.centres.clear();
    for (const glm::ivec3& v : scratch.voxels) scratch.centres.push_back(dense.frame.to_world(dvec3(v)));
    if (scratch.distances.size() < near.size()) scratch.distances.resize(near.size());
    for (std::size_t k = 0; k < near.size(); ++k) {
      scratch.distances[k].resize(scratch.centres.size());
      near[k]->solid->distances(scratch.centres, scratch.distances[k]);
    }
    for (std::size_t n = 0; n < scratch.voxels.size(); ++n) {
      const glm::ivec3 v = scratch.voxels[n];
      const std::size_t i = dense.at(v.x, v.y, v.z);
      double d = kInfinity;
      bool at_border = false;
      for (std::size_t k = 0; k < near.size(); ++k) {
        const double own = scratch.distances[k][n];
        at_border = at_border || std::abs(own) <= kHalfVoxel * h;
        d = std::min(d, own);
      }
      const LabelledSolid* part = nullptr;
      if (at_border && near.size() > 1)
        part = part_inside(near, scratch.centres[n] + h * place_within(glm::ivec3(first) + v));
      if (!part) part = part_around(near, scratch.distances, n, h);
      dense.distance[i] = static_cast<float>(std::clamp(d, -dense.band, dense.band));
      label(i, part);
    }
  };
  const auto slab = [&](std::size_t x) {
    Scratch scratch;
    for (int y = 0; y < dense.size.y; y += kBlock) {
      for (int z = 0; z < dense.size.z; z += kBlock) block({static_cast<int>(x) * kBlock, y, z}, scratch);
    }
  };
  in_parallel(static_cast<std::size_t>((dense.size.x + kBlock - 1) / kBlock), slab, {}, 1, SIZE_MAX);
  return dense;
}

}  // namespace typodont::haptics
