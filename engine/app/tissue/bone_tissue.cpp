#include "engine/app/tissue/bone_tissue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "engine/app/assets.h"
#include "engine/app/tissue/blend.h"
#include "engine/app/tissue/row.h"
#include "engine/base/in_parallel.h"
#include "engine/base/keys.h"
#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/dense_tissue.h"

namespace typodont {

namespace {

// Below the dense outer shell, the grey value changes from cortical to cancellous over this depth, m.
constexpr double kEndosteum = 0.5e-3;
// Distance between the points with random grey values, m: several times the distance between trabeculae.
constexpr double kGrain = 1.2e-3;
constexpr double kMaxVoxels = 2e8;
// Gum, m: thickness of its edge; radius of the edges of a flap; width of the blend between teeth and bone.
constexpr double kGumEdge = 0.45e-3, kFlapEdge = 0.8e-3, kGumBlend = 2e-3;

/// Random number for a grid point, −1 to 1 (splitmix64).
double lattice(std::uint64_t seed, const glm::ivec3& at) {
  std::uint64_t x = seed * 0x9e3779b97f4a7c15u +
                    static_cast<std::uint64_t>(static_cast<std::uint32_t>(at.x)) * 0xbf58476d1ce4e5b9u +
                    static_cast<std::uint64_t>(static_cast<std::uint32_t>(at.y)) * 0x94d049bb133111ebu +
                    static_cast<std::uint64_t>(static_cast<std::uint32_t>(at.z)) * 0xd6e8feb86659fd93u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1;
}

/// Random noise, −1 to 1, interpolated between the grid points.
double noise(std::uint64_t seed, const dvec3& p) {
  const glm::ivec3 at(glm::floor(p));
  dvec3 f = p - dvec3(at);
  f = f * f * (3.0 - 2.0 * f);
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 o(c & 1, c >> 1 & 1, c >> 2 & 1);
    sum += lattice(seed, at + o) * (o.x ? f.x : 1 - f.x) * (o.y ? f.y : 1 - f.y) * (o.z ? f.z : 1 - f.z);
  }
  return sum;
}

/// The object "bone" of a scene, without the mesh.
struct Bone {
  double scale = 1e-3;  // m, one unit of the mesh's file
  double voxel = 0, band = 0;
  dvec3 lo{0}, hi{0};  // m, frame W, lower and upper corner of the sampled box
  Pose X_MW;           // pose of the scene's frame W in mesh frame M
  BoneClass made_of;
  BoneGrey grey;
  double variation = 0;  // largest variation of cancellous bone's grey value, relative to the mean
  std::uint64_t seed = 1;
  double canal_wall = 0;  // m, thickness of the cortical bone around the canal
  NerveCanal canal;
  std::vector<RowTooth> teeth;   // in frame W
  double gum = 0, gum_edge = 0;  // m: thickness, 0 without gum; height z of its edge

  /// Distance to the nearest tooth, m, exact from a few voxels inside to the band's width outside, and continuous as
  /// far as the tooth shapes the gum. `nearest`: the tooth.
  double to_teeth(const dvec3& p_W, const RowTooth** nearest = nullptr) const {
    const double reach = gum > 0 ? std::max(band, gum + kGumBlend) : band;
    double best = std::numeric_limits<double>::infinity();
    for (const RowTooth& tooth : teeth) {
      const dvec3 p = tooth.to_form(p_W), out = glm::max(tooth.form.low() - p, p - tooth.form.high());
      double d = std::max({out.x, out.y, out.z});
      if (d < reach) d = tooth.form.distance(p);
      if (-4 * voxel < d && d < reach) {
        const double exact =
            first_order_distance(std::bind_front(&ToothForm::distance, &tooth.form), p, d, 0.25 * voxel, 0.5);
        d = glm::mix(exact, d, smooth_step(band, reach, d));
      }
      if (d >= best) continue;
      best = d;
      if (nearest) *nearest = &tooth;
    }
    return best;
  }
};

void describe(Keys& keys, Bone& bone) {
  const Json* json = keys.json();
  const auto mesh = [&](Keys& of) {
    std::string file;
    of(must("file"), file, "the closed mesh");
    of("scale", bone.scale, {1e-6, 1e6, kMillimetre}, "length of one unit of the file in millimetres");
  };
  keys(must("mesh"), mesh, "the closed mesh");
  dvec3 site_M(0), place_W(0), y(0, 1, 0);
  keys(must("site_mm"), site_M, kMillimetre, "a point in the mesh file's own frame, in millimetres");
  // In the scene, y points to the tongue, z up.
  if (const auto lingual = keys(must("lingual"), kDirection, "horizontal; becomes the scene's +y; z does not change")) {
    y = lingual->vec3();
    y.z = 0;
    if (!(glm::length(y) > 1e-9)) lingual->fail("a horizontal direction, not zero");
    y = glm::normalize(y);
  }
  keys(must("place_mm"), place_W, kMillimetre, "position of `site_mm` in the scene");
  const dvec3 z(0, 0, 1);
  const dquat R_MW = glm::normalize(glm::quat_cast(glm::dmat3(glm::cross(y, z), y, z)));
  bone.X_MW = {site_M - R_MW * place_W, R_MW};
  if (const auto name =
          keys(must("class"), kName, "density class `I` to `IV` (`assets/materials/bone_classes.json`)")) {
    bone.made_of = load_bone_class(*name);
    bone.grey = load_bone_grey();
  }
  if (!json) bone.made_of.cortical_thickness = kNoDefault;
  keys("cortical_mm", bone.made_of.cortical_thickness, {0, 20, kMillimetre},
       "thickness of the cortical shell; default: that of the class");
  keys("cancellous_HU", bone.made_of.cancellous_grey, {1, bone.grey.cancellous},
       "grey value of the cancellous bone; default: that of the class");
  bone.voxel = 0.15e-3, bone.band = 1.5e-3;
  keys("voxel_mm", bone.voxel, {0.04, 1, kMillimetre}, "as for [solids](#solids)");
  keys("band_mm", bone.band, {0.2, 10, kMillimetre}, "as for [solids](#solids); at least three voxels");
  if (json && bone.band < 3 * bone.voxel) (*json)["band_mm"].fail("at least three voxels");
  if (const auto domain =
          keys(must("domain_mm"), kBox, "at most 200 million voxels; the bone ends two voxels inside")) {
    haptics::read_box(*domain, bone.lo, bone.hi);
    const dvec3 size = (bone.hi - bone.lo) / bone.voxel;
    if (size.x * size.y * size.z > kMaxVoxels) {
      domain->fail(fmt::format("{:.3g} voxels", size.x * size.y * size.z),
                   fmt::format("at most {:.0g}: a larger voxel or a smaller domain", kMaxVoxels));
    }
  }
  keys("remove", kSolids, "[solids](#solids) to remove, such as teeth; the shell follows");
  const auto canal = [&](Keys& of) {
    describe_canal(of, bone.canal);
    bone.canal_wall = 0.4e-3;
    of("wall_mm", bone.canal_wall, {0, 3, kMillimetre}, "thickness of the cortical bone around the canal");
  };
  keys("canal", canal, "the nerve canal. Nerve and vessels in it have the label `pulp`");
  ToothForms forms;
  keys(
      "teeth", bone.teeth, [&](Keys& of, RowTooth& tooth) { describe_row_tooth(of, tooth, tooth_forms(), forms); },
      "teeth in the bone, as in a [row of teeth](#row-of-teeth), but in the scene's frame, with the forms of "
      "`assets/teeth/forms`");
  const auto gum = [&](Keys& of) {
    of(must("thickness_mm"), bone.gum, {0.5, 5, kMillimetre}, "thickness below its edge");
    of(must("edge_mm"), bone.gum_edge, {-1e3, 1e3, kMillimetre}, "height z of its edge");
    of("flap", kSolids, "[solids](#solids) in which the gum is cut off and the bone is bare");
  };
  keys("gum", gum, "gum on bone and teeth. It is rigid");
  bone.variation = 0.15;
  keys("variation", bone.variation, {0, 0.9}, "relative variation of the cancellous grey values");
  keys("seed", bone.seed, {0}, "seed of the variation");
}

Bone read(const Json& json) {
  return read_keys(json, describe);
}

std::filesystem::path bone_classes_file() {
  return assets_folder() / "materials" / "bone_classes.json";
}

}  // namespace

std::vector<std::filesystem::path> bone_files(const Json& bone) {
  std::vector<std::filesystem::path> files{bone_classes_file()};
  if (const auto teeth = bone.find("teeth"))
    for (const Json& tooth : teeth->items()) files.push_back(tooth_forms() / (tooth["form"].string() + ".json"));
  return files;
}

BoneClass load_bone_class(const Json& name) {
  const Json classes = Json::load(bone_classes_file())["classes"];
  const std::string wanted = name.string();
  if (!classes.has(wanted)) name.fail(fmt::format("one of: {}", fmt::join(classes.keys(), ", ")));
  const Json json = classes[wanted];
  json.allow_only({"cortical_mm", "cortical_HU", "cancellous_HU", "source"});
  return {json["cortical_mm"].number(0, 20) * kMillimetre, json["cortical_HU"].number(1, 1e4),
          json["cancellous_HU"].number(1, 1e4)};
}

BoneGrey load_bone_grey() {
  const Json json = Json::load(bone_classes_file())["grey_at_hardness_1_HU"];
  json.allow_only({"cortical_bone", "cancellous_bone", "source"});
  return {json["cortical_bone"].number(1, 1e4), json["cancellous_bone"].number(1, 1e4)};
}

double NerveCanal::distance(const dvec3& p_W) const {
  return distance_to_path(path_W, p_W) - radius;
}

NerveCanal read_nerve_canal(const Json& tissue) {
  const auto bone = tissue.find("bone");
  return bone ? read(*bone).canal : NerveCanal{};
}

void describe_canal(Keys& keys, NerveCanal& canal) {
  if (const auto path = keys(must("path_mm"), kPoints, "at least two points of the centre line")) {
    for (const Json& point : path->items()) canal.path_W.push_back(point.vec3() * kMillimetre);
    if (canal.path_W.size() < 2) path->fail("at least two points");
  }
  keys(must("diameter_mm"), canal.radius, {0.5, 8, kMillimetre / 2}, "diameter");
}

void describe_bone(Keys& keys) {
  Bone bone;
  describe(keys, bone);
}

haptics::DenseTissue sample_bone(const Json& json, const haptics::SolidFiles& files) {
  const Bone bone = read(json);
  const Json mesh = json["mesh"];
  const auto jaw = files.read_mesh(files.find(mesh["file"]), bone.scale);
  const auto solids = [&](const std::optional<Json>& list) {
    return haptics::read_solid_list(list ? list->items() : std::vector<Json>(), files);
  };
  const auto removed = solids(json.find("remove")),
             flap = solids(bone.gum > 0 ? json["gum"].find("flap") : std::nullopt);
  haptics::DenseTissue dense;
  dense.band = bone.band;
  const double h = bone.voxel;
  const dvec3 first = glm::floor(bone.lo / h), last = glm::ceil(bone.hi / h);
  dense.frame = {first * h, h};
  dense.size = glm::ivec3(last - first + 1.0);
  const std::size_t count = voxel_count(dense.size);
  dense.distance.resize(count);
  dense.tissue.assign(count, Tissue::kAir);
  dense.hardness.assign(count, haptics::kOwnHardness);
  // Distance to the jaw without the removed solids. `to_jaw`: distance to the mesh at p_W. The bone has sharp edges at
  // these solids; the gum lies on rounded ones.
  struct JawDistance {
    double sharp, rounded;
  };
  const auto at = [&](const dvec3& p_W, double to_jaw) {
    JawDistance cut{to_jaw, to_jaw};
    for (const auto& solid : removed) {
      const double outside = -solid->distance(p_W);
      cut = {std::max(cut.sharp, outside), smooth_max(cut.rounded, outside, kGumBlend)};
    }
    return cut;
  };
  // Distance to the gum. `hard`: distance to bone and teeth.
  const auto to_gum = [&](const dvec3& p_W, double hard) {
    if (bone.gum == 0) return std::numeric_limits<double>::infinity();
    double d = hard - gum_thickness(bone.gum_edge - p_W.z, kGumEdge, bone.gum, 2 * bone.gum);
    for (const auto& solid : flap) d = smooth_max(d, -solid->distance(p_W), kFlapEdge);
    return d;
  };
  // Blocks far from the jaw are recognised by the distance to the jaw at their middle: inside a block, this distance
  // differs from its value at the middle by at most `reach`: half the diagonal times the largest gradient.
  constexpr int kBlock = 8;
  constexpr double kGumSteepest = 1.7;  // largest slope of the distance function of gum; that of bone is 1
  const double reach = 0.5 * std::sqrt(3.0) * (kBlock - 1) * h * kGumSteepest;
  const auto voxel = [&](std::size_t i, const dvec3& p_W, double to_jaw) {
    const RowTooth* nearest = nullptr;
    const auto [outer, rounded] = at(p_W, to_jaw);
    const double canal = bone.canal.distance(p_W);
    const double tooth = bone.to_teeth(p_W, &nearest), gum = to_gum(p_W, smooth_min(rounded, tooth, kGumBlend));
    // The mesh may extend beyond the box. So the bone is cut off just inside the box's faces.
    const dvec3 beyond = glm::max(bone.lo + 2.0 * h - p_W, p_W - (bone.hi - 2.0 * h));
    const double d = std::max({std::min({outer, tooth, gum}), beyond.x, beyond.y, beyond.z});
    dense.distance[i] = static_cast<float>(std::clamp(d, -dense.band, dense.band));
    if (d > 1.5 * h) return;
    if (tooth < 0 || tooth < std::min(outer, gum)) {
      dense.tissue[i] = nearest->form.tissue(nearest->to_form(p_W));
      return;
    }
    if (outer > 0 && gum < outer) {
      dense.tissue[i] = Tissue::kGingiva;
      return;
    }
    if (canal < 0) {
      dense.tissue[i] = kNerve;
      return;
    }
    const double below = std::min(-outer - bone.made_of.cortical_thickness, canal - bone.canal_wall);
    const bool cortical = below < 0;
    const double cancellous_grey = bone.made_of.cancellous_grey * (1 + bone.variation * noise(bone.seed, p_W / kGrain));
    // The grey value changes from cortical to cancellous over kEndosteum.
    const double blend = std::clamp(below / kEndosteum, 0.0, 1.0);
    const double grey = cortical ? bone.made_of.cortical_grey
                                 : std::min(bone.grey.cancellous,
                                            cancellous_grey + (1 - blend) * (bone.grey.cancellous - cancellous_grey));
    dense.tissue[i] = cortical ? Tissue::kCorticalBone : Tissue::kCancellousBone;
    dense.hardness[i] = haptics::hardness_byte(grey / (cortical ? bone.grey.cortical : bone.grey.cancellous));
  };
  struct Scratch {
    std::vector<glm::ivec3> voxels;
    std::vector<dvec3> p_M;  // m, in the frame of the mesh
    std::vector<double> to_jaw;
  };
  const auto block = [&](const glm::ivec3& from, Scratch& scratch) {
    const dvec3 middle_W = dense.frame.to_world(dvec3(from) + 0.5 * (kBlock - 1));
    haptics::voxels_of_block(from, glm::min(from + kBlock, dense.size), scratch.voxels);
    const double hard =
        smooth_min(at(middle_W, jaw->distance(bone.X_MW * middle_W)).sharp, bone.to_teeth(middle_W), kGumBlend);
    if (std::min(hard, to_gum(middle_W, hard)) - reach > dense.band) {
      for (const glm::ivec3& v : scratch.voxels)
        dense.distance[dense.at(v.x, v.y, v.z)] = static_cast<float>(dense.band);
      return;
    }
    const auto place = [&](const glm::ivec3& v) { return dense.frame.to_world(dvec3(v)); };
    scratch.p_M.clear();
    for (const glm::ivec3& v : scratch.voxels) scratch.p_M.push_back(bone.X_MW * place(v));
    scratch.to_jaw.resize(scratch.p_M.size());
    jaw->distances(scratch.p_M, scratch.to_jaw);
    for (std::size_t n = 0; n < scratch.voxels.size(); ++n) {
      const glm::ivec3 v = scratch.voxels[n];
      voxel(dense.at(v.x, v.y, v.z), place(v), scratch.to_jaw[n]);
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

}  // namespace typodont
