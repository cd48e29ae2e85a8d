#include "engine/app/picture/tissue_view.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "engine/base/vectors.h"
#include "engine/render/look.h"
#include "engine/render/sphere_directions.h"
#include "haptics/tissue_volume.h"

namespace typodont {

namespace {

/// Makes the surface of the distance field, without the colours of the voxels.
surface::WholeMesh field_surface(const haptics::TissueVolume& volume, float tolerance,
                                 const std::function<void(double)>& progress) {
  const auto at = [&](double fraction) {
    if (progress) progress(fraction);
  };
  surface::SurfaceMesher mesher({.tolerance = tolerance});
  FieldBrick brick;
  const std::vector<glm::ivec3> bricks = volume.surface_bricks();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    at(0.4 * static_cast<double>(i) / static_cast<double>(bricks.size()));
    volume.read_brick(bricks[i], brick);
    mesher.put(brick);
  }
  mesher.remesh();
  at(0.9);
  surface::WholeMesh mesh = surface::weld(mesher);
  at(1);
  return mesh;
}

}  // namespace

surface::WholeMesh whole_surface(const haptics::TissueVolume& volume, bool own, float tolerance,
                                 const std::function<void(double)>& progress) {
  surface::WholeMesh mesh =
      own ? whole_surface(*volume.mesh(), volume.frame()) : field_surface(volume, tolerance, progress);
  if (!volume.colored()) return mesh;
  for (surface::WholeMesh::Vertex& v : mesh.vertices) v.paint = volume.color_at(dvec3(v.position));
  return mesh;
}

surface::WholeMesh whole_surface(const haptics::TissueMesh& mesh, const VoxelFrame& frame) {
  surface::WholeMesh whole;
  whole.vertices.resize(mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    whole.vertices[v].position = glm::vec3(frame.to_voxels(mesh.vertices[v]));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& c = mesh.triangles[t];
    whole.triangles.push_back({c.x, c.y, c.z});
    const dvec3& a = mesh.vertices[c.x];
    const glm::vec3 normal(glm::cross(mesh.vertices[c.y] - a, mesh.vertices[c.z] - a) / (frame.voxel * frame.voxel));
    for (int k = 0; k < 3; ++k) {
      surface::WholeMesh::Vertex& vertex = whole.vertices[c[k]];
      vertex.normal += normal;
      vertex.tissue = mesh.tissue[t];
    }
  }
  for (surface::WholeMesh::Vertex& vertex : whole.vertices)
    vertex.normal = glm::length(vertex.normal) > 0 ? glm::normalize(vertex.normal) : glm::vec3(0, 0, 1);
  return whole;
}

void add_paint(const haptics::TissueVolume& volume, std::vector<render::MeshUpdate>& updates, const DrawnAs& drawn_as) {
  if (!volume.colored() && !volume.graded()) return;
  std::uint32_t as_themselves = 0;
  for (int t = 0; t < kTissueCount; ++t)
    as_themselves |= (drawn_as(static_cast<Tissue>(t)) == static_cast<Tissue>(t) ? 1u : 0u) << t;
  const auto decay = [&](Tissue tissue, double hardness, VoxelColor /*color*/) {
    const bool counts = as_themselves >> static_cast<int>(tissue) & 1;
    return counts ? glm::dvec4(render::decay_paint(tissue, hardness)) : glm::dvec4(0);
  };
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& v : update.vertices) {
      const dvec3 p_V = dvec3(v.p) / volume.frame().voxel;
      v.paint = volume.color_at(p_V, as_themselves);
      if (v.paint.w == 0 && volume.graded()) v.paint = volume.paint_at(p_V, decay);
      v.shows *= 1 - v.paint.w;
      v.lesion *= 1 - v.paint.w;
    }
}

TissueCopy copy_of(haptics::Carver& carver) {
  TissueCopy copy{carver.volume().clone(), std::nullopt};
  if (const haptics::TissueSurface* own = carver.surface()) copy.own = own->mesh();
  return copy;
}

void save_tissue(const TissueCopy& tissue, const std::filesystem::path& file) {
  tissue.volume.save(file);
  if (!tissue.own) return;
  std::filesystem::path beside = file;
  beside.replace_filename(file.stem().string() + "_surface.stl");
  const VoxelFrame& frame = tissue.volume.frame();
  surface::write_mesh(beside, whole_surface(*tissue.own, frame), frame, {});
}

namespace {

// Search depth for another tissue below a vertex, voxels.
constexpr int kSearchDepth = 14;
// A vertex counts as cut if the tissue before the first cut reached this far above it, voxels. A larger value would
// include vertices in fissures, because the opposite wall is near.
constexpr double kCutSeen = 0.9;
constexpr int kRemeshedPerUpdate =
    // Number of bricks that are meshed again per update after a change of tolerance. They
    // take only some milliseconds, so the servo's next tissue patch is not delayed.
    32;

/// Depth through which the colour of an inner tissue is visible, m: dentin and caries through enamel, pulp through thin
/// dentin.
constexpr double translucency_depth(Tissue tissue) {
  switch (tissue) {
    case Tissue::kEnamel:
      return 1.7e-3;
    case Tissue::kDentin:
      return 0.9e-3;
    case Tissue::kCaries:
      return 0.5e-3;
    default:
      return 0;
  }
}

/// Rounds down. The conversion rounds towards zero: negative numbers are corrected.
FourInts rounded_down(const Four& v) {
  const FourInts i = __builtin_convertvector(v, FourInts);
  return i + (v < __builtin_convertvector(i, Four));  // each lane of a true comparison is −1
}
/// The voxels that contain four points.
SolidBlocks::Voxels voxels_with(const Four& x, const Four& y, const Four& z) {
  return {rounded_down(x), rounded_down(y), rounded_down(z)};
}

bool translucent(Tissue tissue) {
  return tissue == Tissue::kEnamel || tissue == Tissue::kDentin;
}

}  // namespace

void TissueView::find_cuts_and_edges(const haptics::TissueVolume& volume, render::MeshUpdate& update) {
  const haptics::NaturalSurface* const natural = volume.natural_surface().get();
  const dvec3& origin = volume.frame().origin;
  const double voxel = volume.frame().voxel;
  // Distance between test points on the line from a vertex into the tissue, voxels; usual gaps in tissue are wider.
  constexpr float kProbe = 3.5f;
  constexpr Four kWays = {kProbe, 2 * kProbe, 3 * kProbe, 4 * kProbe};  // voxels, depths of the test points
  static_assert(4 * kProbe >= kSearchDepth);
  constexpr float kBeside = 2;  // voxels, approximate distance of four additional test points from this line
  const auto most = static_cast<float>(std::min(render::kTranslucentThickness / voxel, double{kSearchDepth}));
  const int probes = static_cast<int>(most / kProbe);
  for (render::Vertex& v : update.vertices) {
    if (!translucent(v.tissue[0]) && !translucent(v.tissue[1])) continue;
    if (natural) {
      const double before = natural->inside(origin + dvec3(v.p) + kCutSeen * voxel * dvec3(v.n));
      v.cut = static_cast<float>(std::clamp(2 * before - 0.5, 0.0, 1.0));
    }
    const glm::vec3 start = v.p / static_cast<float>(voxel) + 0.5f;
    // Bit i: test point i at depth `ways[i]` is in tissue, for the first `count` points.
    const auto solid_at = [&](const Four& ways, int count) {
      return solid_.solid(volume, voxels_with(start.x - ways * v.n.x, start.y - ways * v.n.y, start.z - ways * v.n.z),
                          count);
    };
    // The line of test points can leave a thick body through the body's side. So
    // tissue counts as thin only if four points around the first gap are empty too.
    const auto all_empty_at = [&](float distance) {
      const glm::vec3 axis = std::abs(v.n.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
      // Four test points: corners of a square around `place` in the plane perpendicular to v.n, turned by 27°.
      const glm::vec3 level = glm::normalize(glm::cross(v.n, axis));
      const glm::vec3 along = kBeside * (level + 0.5f * glm::cross(v.n, level)), across = glm::cross(v.n, along);
      const glm::vec3 place = start - distance * v.n;
      constexpr Four kAlong = {1, -1, 0, 0}, kAcross = {0, 0, 1, -1};
      return solid_.solid(volume,
                          voxels_with(place.x + kAlong * along.x + kAcross * across.x,
                                      place.y + kAlong * along.y + kAcross * across.y,
                                      place.z + kAlong * along.z + kAcross * across.z),
                          4) == 0;
    };
    const unsigned left = ~solid_at(kWays, probes) & ((1u << probes) - 1);
    if (left == 0) continue;
    const float distance = kWays[std::countr_zero(left)];  // depth of the first test point outside the tissue
    if (!all_empty_at(distance)) continue;
    float near = distance - kProbe, far = distance;
    for (int i = 0; i < 3; ++i) {
      const float middle = 0.5f * (near + far);
      (solid_at(Four{middle}, 1) ? near : far) = middle;
    }
    v.thin = 1 - 0.5f * (near + far) * static_cast<float>(voxel / render::kTranslucentThickness);
  }
}

float TissueView::nearness_of_caries(const haptics::TissueVolume& volume, const glm::vec3& start,
                                     const glm::vec3& inward, float reach) {
  const glm::ivec3 all(static_cast<int>(reach) + 1), middle(start);
  if (!labels_.may_contain(middle - all, middle + all, Tissue::kCaries)) return 0;
  static const auto directions = render::sphere_directions<40>();
  constexpr float kBelow = 1.5f, kStep = 1;  // voxels: depth below the surface; distance between test points
  // The test path starts below the surface, so that a path parallel to the surface stays in the tissue.
  const glm::vec3 from = start + kBelow * inward;
  float nearest = reach;
  for (const glm::vec3& d : directions)
    for (float distance = kStep; distance < nearest; distance += kStep) {
      const Tissue found = labels_.at(volume, glm::ivec3(from + distance * d));
      if (found == Tissue::kCaries) nearest = distance;
      if (found == Tissue::kCaries || found == Tissue::kAir) break;
    }
  return 1 - nearest / reach;
}

void TissueView::find_tissue_below(const haptics::TissueVolume& volume, render::MeshUpdate& update) {
  const double voxel = volume.frame().voxel;
  const auto own = [](const render::Vertex& v) { return v.tissue[v.second > 0.5f ? 1 : 0]; };
  if (update.vertices.empty()) return;
  find_cuts_and_edges(volume, update);
  // Labels are needed for the voxels below the vertices and a few around them.
  std::array<float, kTissueCount> reach_below;  // voxels, searched depth below a vertex, for each tissue
  for (int t = 0; t < kTissueCount; ++t)
    reach_below[static_cast<std::size_t>(t)] = static_cast<float>(
        std::min(translucency_depth(static_cast<Tissue>(t)) / voxel, static_cast<double>(kSearchDepth)));
  const auto reach_of = [&](const render::Vertex& v) { return reach_below[static_cast<std::size_t>(own(v))]; };
  glm::vec3 low(update.vertices.front().p), high(low);
  for (const render::Vertex& v : update.vertices) {
    const glm::vec3 end = v.p - reach_of(v) * static_cast<float>(voxel) * v.n;
    low = glm::min(low, glm::min(v.p, end)), high = glm::max(high, glm::max(v.p, end));
  }
  if (!has_caries_) has_caries_ = volume.contains(Tissue::kCaries);
  const auto lesion_reach = *has_caries_ ? static_cast<float>(render::kLesionReach / voxel) : 0.0f;  // voxels
  const int margin = static_cast<int>(lesion_reach) + 3;
  labels_.look_at(volume, glm::ivec3(glm::floor(dvec3(low) / voxel)) - margin,
                  glm::ivec3(glm::ceil(dvec3(high) / voxel)) + margin);
  // With one tissue, nothing is visible through it, and there is no border to draw.
  if (labels_.one_tissue()) return;
  const glm::ivec3 lo = labels_.origin();
  for (render::Vertex& v : update.vertices) {
    if (v.tissue[0] != v.tissue[1] && v.tissue[0] != Tissue::kAir) {
      // Labels give a stepped border. The border is drawn where the smoothed fractions of both tissues are equal.
      const dvec3 at = dvec3(v.p) / voxel - dvec3(lo);
      const glm::ivec3 nearest(glm::floor(at + 0.5));
      float weight[3][5];  // exp(−0.6 r²) as a product over the axes; r: voxels
      for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 5; ++k) {
          const auto away = static_cast<float>(nearest[axis] + k - 2 - at[axis]);
          weight[axis][k] = std::exp(-0.6f * away * away);
        }
      float first = 0, second = 0;
      for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y) {
          const float across = weight[0][x] * weight[1][y];
          for (int z = 0; z < 5; ++z) {
            const Tissue label = labels_.at(volume, nearest + glm::ivec3(x - 2, y - 2, z - 2));
            const float w = across * weight[2][z];
            first += label == v.tissue[0] ? w : 0;
            second += label == v.tissue[1] ? w : 0;
          }
        }
      if (first + second > 0) v.second = second / (first + second);
    }
    const float reach = reach_of(v);
    if (reach == 0) continue;
    // The coordinates are positive here, so the conversion rounds down.
    const glm::vec3 start(dvec3(v.p) / voxel - dvec3(lo) + 0.5), inward = -v.n;
    const auto seen_at = [&](float distance) { return labels_.at(volume, glm::ivec3(start + distance * inward)); };
    const Tissue outside = own(v);
    if (lesion_reach > 0 && translucent(outside)) v.lesion = nearness_of_caries(volume, start, inward, lesion_reach);
    // Dentin beside enamel is drawn as enamel of thickness zero over dentin, so that the interpolated colour has no
    // step.
    if (outside == Tissue::kDentin && (v.tissue[0] == Tissue::kEnamel || v.tissue[1] == Tissue::kEnamel)) {
      v.under = Tissue::kDentin, v.shows = 1;
      continue;
    }
    const glm::ivec3 top(start), bottom(start + reach * inward);
    if (!labels_.may_contain_others(glm::min(top, bottom), glm::max(top, bottom),
                                    LabelBlocks::set_of(outside) | LabelBlocks::set_of(Tissue::kAir)))
      continue;
    for (float distance = 0.75f; distance < reach; distance += 0.5f) {
      if (seen_at(distance) == outside) continue;
      // A deeper tissue begins between the last two points; bisection finds its depth to an eighth of a voxel.
      float near = std::max(distance - 0.5f, 0.5f), far = distance;
      for (int i = 0; i < 2; ++i) {
        const float middle = 0.5f * (near + far);
        (seen_at(middle) == outside ? near : far) = middle;
      }
      const Tissue found = seen_at(far);
      if (found == Tissue::kAir) break;
      const float left = 1 - far / reach;
      v.under = found;
      v.depth = far * static_cast<float>(voxel);
      v.shows = left * std::sqrt(left);
      // Vertex::lesion also colours the tissue near caries, so the caries below shines through less there.
      if (found == Tissue::kCaries) v.shows *= 1 - v.lesion;
      break;
    }
  }
}

TissueView::TissueView(float tolerance, const DrawnAs& drawn_as)
    : drawn_as_(drawn_as), labels_(drawn_as), mesher_({.tolerance = tolerance}), tolerance_(tolerance) {}

void TissueView::put(const haptics::TissueVolume& volume, const glm::ivec3& key) {
  volume.read_brick(key, brick_);
  drawn_as_.apply(brick_.tissue);
  mesher_.put(brick_);
}

void TissueView::set_tolerance(float tolerance) {
  if (tolerance == tolerance_) return;
  tolerance_ = tolerance;
  mesher_.set_tolerance(tolerance);
  another_tolerance_ = true;
}

std::vector<render::MeshUpdate> TissueView::update(haptics::TissueVolume& volume) {
  const auto changed = volume.take_changed_bricks();
  for (const glm::ivec3& key : started_ ? changed : volume.surface_bricks()) put(volume, key);
  if (std::exchange(another_tolerance_, false) && started_) outdated_ = volume.surface_bricks();
  started_ = true;
  for (const glm::ivec3& key : changed)  // bricks where tissue was painted or restored
    for (int block = 0; has_caries_ == false && block < 8; ++block)
      has_caries_ = volume.tissues_in_block(2 * key + glm::ivec3(block >> 2, block >> 1 & 1, block & 1)) >>
                        static_cast<int>(Tissue::kCaries) &
                    1;
  for (int i = 0; i < kRemeshedPerUpdate && !outdated_.empty(); ++i) {
    put(volume, outdated_.back());
    outdated_.pop_back();
  }
  // Caries also stains neighbouring bricks. Stained bricks beside a changed brick are meshed again, one per update.
  for (const glm::ivec3& key : changed)
    for (const glm::ivec3& stained : stained_)
      if (glm::all(glm::lessThanEqual(glm::abs(stained - key), glm::ivec3(1))) &&
          std::ranges::find(stale_, stained) == stale_.end())
        stale_.push_back(stained);
  if (!stale_.empty()) {
    put(volume, stale_.front());
    stale_.erase(stale_.begin());
  }
  std::vector<render::MeshUpdate> updates;
  labels_.forget();
  solid_.forget();
  mesher_.remesh([&](const surface::BrickMesh& mesh) {
    updates.push_back(brick_update(mesh, volume.frame().voxel));
    find_tissue_below(volume, updates.back());
    std::erase(stained_, mesh.key);
    if (std::ranges::any_of(updates.back().vertices, [](const render::Vertex& v) { return v.lesion > 0; }))
      stained_.push_back(mesh.key);
  });
  add_paint(volume, updates, drawn_as_);
  return updates;
}

std::vector<render::MeshUpdate> TissueView::update(haptics::TissueSurface& surface) {
  const haptics::TissueVolume& labels = surface.labels();
  solid_.forget();
  std::vector<render::MeshUpdate> updates;
  for (const haptics::SurfacePiece& piece : surface.take_changed()) {
    render::MeshUpdate& update = updates.emplace_back();
    update.brick = brick_number(piece.cell);
    update.two_sided = surface.open();
    update.indices = piece.indices;
    update.vertices.reserve(piece.corners.size());
    for (const haptics::SurfaceCorner& corner : piece.corners) {
      render::Vertex& v = update.vertices.emplace_back();
      v.p = corner.p, v.n = corner.n, v.second = corner.second;
      v.tissue = {drawn_as_(corner.tissue[0]), drawn_as_(corner.tissue[1])};
    }
    find_tissue_below(labels, update);
  }
  add_paint(labels, updates, drawn_as_);
  return updates;
}

std::vector<render::MeshUpdate> TissueView::update(haptics::Carver& carver) {
  haptics::TissueSurface* const own = carver.surface();
  return own ? update(*own) : update(carver.volume());
}

}  // namespace typodont
