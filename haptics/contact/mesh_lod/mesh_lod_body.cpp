#include "haptics/contact/mesh_lod/mesh_lod_body.h"

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "engine/base/error.h"
#include "haptics/contact/vertex/head_follow.h"

namespace typodont::haptics::mesh_lod {

MeshLodBody::MeshLodBody(TissueVolume tissue, std::span<const Tool> tools, const Parameters& parameters)
    : travel_(LocalParameters::travel_for(tools)) {
  const TissueMesh mesh = surface_mesh(tissue);
  if (mesh.triangles.empty()) throw Error("mesh_lod", "tissue", "a volume without a surface", "tissue");
  levels_ = make_levels(mesh, parameters.levels);
  for (const Tool& tool : tools) {
    reach_ = std::max(reach_, tool.reach());
    heads_.emplace_back();
    if (!whole_head(tool)) continue;
    heads_.back().emplace(tool);
    if (!lister_) lister_ = std::make_unique<HeadLister>();
  }
  vertex::Parameters cutting;
  if (!(travel_ < std::numeric_limits<double>::infinity())) cutting.spare = 0;
  solid_.emplace(std::move(tissue), levels_->finest, tools, cutting);
}

void MeshLodBody::carve(const Cut& cut, bool continues) {
  solid_->carve(cut, continues);
  cut_ = true;
  tool_ = cut.tool, X_W_ = cut.X_WB;
  if (!first_) first_ = cut.t;
}

bool MeshLodBody::wants_snapshot(Nanos t) const {
  return first_ && t - *first_ >= LocalParameters::interval;
}

void MeshLodBody::cut_out(Snapshot& snapshot, std::uint32_t /*held*/) {
  auto& out = static_cast<MeshSnapshot&>(snapshot);
  first_.reset();
  out.levels = levels_;
  out.cut = cut_;
  out.points_of = MeshSnapshot::kNoTool;
  for (std::size_t t = 0; t < out.removed.size(); ++t) out.removed[t] = solid_->removed()[t] - solid_->taken_back()[t];
  if (!cut_) return;
  const double half = LocalParameters::travel + LocalParameters::margin + reach_;
  out.lo = out.center_W - half, out.hi = out.center_W + half;
  TissueMesh local;
  std::unordered_map<mesh::Index, unsigned> number;
  const mesh::EditableMesh& all = solid_->mesh();
  all.near(out.lo, out.hi, [&](mesh::Index f) {
    glm::uvec3 corners;
    for (int k = 0; k < 3; ++k) {
      const mesh::Index v = all.face(f).v[k];
      const auto [it, fresh] = number.try_emplace(v, static_cast<unsigned>(local.vertices.size()));
      if (fresh) local.vertices.push_back(all.vertex(v).p);
      corners[k] = it->second;
    }
    local.triangles.push_back(corners);
    local.tissue.push_back(all.face(f).tissue);
  });
  out.local.clear();
  out.local.emplace_back(local, true);
  for (std::size_t i = 1; i < levels_->vertices.size(); ++i) {
    const double part = static_cast<double>(levels_->vertices[i]) / static_cast<double>(levels_->vertices[0]);
    out.local.emplace_back(thinned(local, part), true);
  }
  list_points(out);
}

/// Lists the contact points around the tool's head at its pose of the last cut, so that the servo need not do it.
void MeshLodBody::list_points(MeshSnapshot& out) {
  if (tool_ >= heads_.size() || !heads_[tool_]) return;
  const vertex::VertexHead& head = *heads_[tool_];
  const double kept = LocalParameters::listed * head.radius();
  const double margin = kept + (vertex::FollowParameters::margin - vertex::FollowParameters::kept) * head.radius();
  const dvec3 half(head.reach() + margin);
  if (glm::any(glm::lessThan(X_W_.p - half, out.lo)) || glm::any(glm::greaterThan(X_W_.p + half, out.hi))) return;
  if (!out.points) out.points = std::make_unique<HeadPoints>();
  lister_->begin(out.local.front(), head, X_W_, margin, kept, *out.points);
  lister_->work(out.local.front(), head, *out.points);
  out.points_of = tool_;
}

}  // namespace typodont::haptics::mesh_lod
