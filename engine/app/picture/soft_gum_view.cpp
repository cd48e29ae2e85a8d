#include "engine/app/picture/soft_gum_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/app/tissue/split_edges.h"

namespace typodont {

namespace {

// Radius within which a point of the soft gum moves the picture's vertices, divided by the distance between
// neighbouring points.
constexpr double kMovedWithin = 1.7;
constexpr float kEdge = 0.3e-3f;    // m, triangles with edges longer than this are divided where the gum can move
constexpr int kSplits = 4;          // largest number of halvings of an edge of the gum
constexpr double kGrowth = 30e-6;   // m, a patch of blood is drawn again after its radius has changed by this
constexpr float kOpaque = 0.95f;    // opacity in the middle of a patch of blood, 0..1
constexpr double kRimWidth = 0.22;  // width of the rim of a blood patch, divided by the radius of the patch
// Smallest width of the rim of a blood patch, m; in a narrower rim, the triangles would be visible.
constexpr double kMinRim = 0.35e-3;

}  // namespace

SoftGumView::SoftGumView(std::shared_ptr<const haptics::SoftSurface> surface, const Surroundings& around)
    : surface_(std::move(surface)), bricks_of_(surface_->points().size()), inward_(surface_->points().size(), 0) {
  for (const SurroundingMesh& mesh : around.meshes) {
    for (const render::MeshUpdate& brick : mesh.bricks) add_brick(mesh, brick, false);
    for (const render::MeshUpdate& brick : mesh.coarse) add_brick(mesh, brick, true);
  }
}

void SoftGumView::add_brick(const SurroundingMesh& mesh, const render::MeshUpdate& whole, bool coarse) {
  if (std::none_of(whole.vertices.begin(), whole.vertices.end(),
                   [](const render::Vertex& v) { return v.tissue[0] == Tissue::kGingiva; })) {
    return;
  }
  const double reach = kMovedWithin * surface_->law().spacing;
  const auto near_points = [&](const dvec3& p_W, auto&& visit) {
    surface_->each_near(p_W - reach, p_W + reach, [&](std::uint32_t point) {
      const dvec3 off = surface_->points()[point].p_W - p_W;
      if (glm::dot(off, off) < reach * reach) visit(point, off);
    });
  };
  const auto is_soft = [&](const glm::vec3& p) {
    bool any = false;
    near_points(mesh.origin + dvec3(p), [&](std::uint32_t, const dvec3&) { any = true; });
    return any;
  };
  Rest rest;
  rest.whole = &whole;
  rest.origin = mesh.origin;
  rest.mesh = whole;
  for (int i = 0; i < kSplits; ++i) {
    if (!split_edges(rest.mesh, [&](const render::Vertex& a, const render::Vertex& b) {
          return glm::length(a.p - b.p) > kEdge && is_soft(0.5f * (a.p + b.p));
        })) {
      break;
    }
  }
  // Shepard's method interpolates the displacements of the points, with weights (1 - (r / reach)²)², where r is the
  // distance of a point.
  glm::vec3 low(1e9f), high(-1e9f);
  const auto brick = static_cast<std::uint32_t>(bricks_.size());
  for (const render::Vertex& vertex : rest.mesh.vertices) {
    low = glm::min(low, vertex.p), high = glm::max(high, vertex.p);
    rest.first.push_back(static_cast<std::uint32_t>(rest.influences.size()));
    double sum = 0;
    dvec3 slope(0);
    near_points(mesh.origin + dvec3(vertex.p), [&](std::uint32_t point, const dvec3& off) {
      // The normals of point and vertex have opposite directions: the vertex is on the far side of a thin layer of gum,
      // so the point does not move it.
      if (glm::dot(surface_->points()[point].n_W, dvec3(vertex.n)) < 0) return;
      const double inside = 1 - glm::dot(off, off) / (reach * reach);
      const dvec3 change = 4 * inside / (reach * reach) * off;
      rest.influences.push_back({point, static_cast<float>(inside * inside), glm::vec3(change)});
      sum += inside * inside, slope += change;
    });
    for (std::size_t i = rest.first.back(); i < rest.influences.size(); ++i) {
      Influence& influence = rest.influences[i];
      const double part = influence.part / sum;
      influence.slope = glm::vec3((dvec3(influence.slope) - part * slope) / sum);
      influence.part = static_cast<float>(part);
    }
  }
  if (rest.influences.empty()) return;
  rest.first.push_back(static_cast<std::uint32_t>(rest.influences.size()));
  rest.middle = mesh.origin + dvec3(0.5f * (low + high));
  rest.radius = 0.5 * glm::length(dvec3(high - low));
  for (const Influence& influence : rest.influences) {
    std::vector<std::uint32_t>& list = bricks_of_[influence.point];
    if (list.empty() || list.back() != brick) list.push_back(brick);
  }
  bricks_.push_back({mesh.id, coarse, {}, 0});
  rest_.push_back(std::move(rest));
}

void SoftGumView::move(const haptics::SoftMove& move) {
  inward_[move.point] = move.inward;
  for (const std::uint32_t brick : bricks_of_[move.point]) mark(brick);
}

/// Marks a mesh brick, which the next follow() computes again.
void SoftGumView::mark(std::uint32_t brick) {
  if (!std::exchange(rest_[brick].changed, true)) changed_.push_back(brick);
}

void SoftGumView::apply(const ServoEvent& event) {
  if (const auto* const moves = std::get_if<GumMoves>(&event)) {
    for (const haptics::SoftMove& moved : std::span(moves->points).first(moves->count)) move(moved);
  } else if (const auto* const wound = std::get_if<haptics::SoftWound>(&event)) {
    bleed(*wound);
  }
}

void SoftGumView::reset() {
  std::fill(inward_.begin(), inward_.end(), 0.0f);
  wounds_.clear();
  for (std::uint32_t brick = 0; brick < bricks_.size(); ++brick) {
    if (bricks_[brick].version > 0) mark(brick);
  }
}

void SoftGumView::follow(Nanos t) {
  for (Wound& wound : wounds_) {
    const double radius = haptics::blood_radius(surface_->law(), to_seconds(t - wound.place.t));
    if (std::abs(radius - wound.drawn) < kGrowth) continue;
    wound.drawn = radius;
    for (std::uint32_t brick = 0; brick < rest_.size(); ++brick) {
      if (glm::length(rest_[brick].middle - wound.place.p_W) > rest_[brick].radius + 1.2 * radius) continue;
      mark(brick);
    }
  }
  if (changed_.empty()) return;
  ++version_;
  for (const std::uint32_t brick : changed_) make(brick);
  changed_.clear();
}

/// Opacity of the blood (0 to 1) at a point of the undeformed surface. The rim of a patch of blood is uneven.
float SoftGumView::blood_at(const dvec3& p_W) const {
  double most = 0;
  for (const Wound& wound : wounds_) {
    if (!(wound.drawn > 0)) continue;
    const dvec3 off = p_W - wound.place.p_W;
    const dvec3 wave = 1600.0 * off;  // with this factor (1600 1/m), the patch's edge has lobes of some millimetres
    const double lobes = std::sin(wave.x + 1.7 * wave.y + 0.4) + std::sin(1.4 * wave.y - 1.1 * wave.z + 2.0) +
                         0.5 * std::sin(2.3 * wave.z - 1.9 * wave.x);
    const double rim = wound.drawn * (1 + 0.05 * lobes);
    most = std::max(most, std::clamp((rim - glm::length(off)) / std::max(kRimWidth * rim, kMinRim), 0.0, 1.0));
  }
  return static_cast<float>(most * most * (3 - 2 * most));
}

void SoftGumView::make(std::size_t index) {
  Rest& rest = rest_[index];
  Brick& brick = bricks_[index];
  rest.changed = false;
  brick.version = version_;
  brick.now = rest.mesh;
  bool at_rest = true;
  for (std::size_t v = 0; v < brick.now.vertices.size(); ++v) {
    render::Vertex& vertex = brick.now.vertices[v];
    glm::vec3 moved(0), slope(0);
    for (std::uint32_t i = rest.first[v]; i < rest.first[v + 1]; ++i) {
      const Influence& influence = rest.influences[i];
      const float inward = inward_[influence.point];
      if (inward == 0) continue;
      moved -= influence.part * inward * glm::vec3(surface_->points()[influence.point].n_W);
      slope += inward * influence.slope;
    }
    const float blood = blood_at(rest.origin + dvec3(vertex.p));
    if (moved == glm::vec3(0) && !(blood > 0)) continue;
    at_rest = false;
    // If each point of a surface with normal n is lowered by a depth h, the new normal is n + ∇h.
    vertex.p += moved;
    vertex.n = glm::normalize(vertex.n + slope - glm::dot(slope, vertex.n) * vertex.n);
    if (blood > 0) {
      vertex.under = Tissue::kPulp;  // the tissue "pulp" is drawn in the colour of blood
      vertex.shows = std::max(vertex.shows, kOpaque * blood);
    }
  }
  if (at_rest) brick.now = *rest.whole;
}

}  // namespace typodont
