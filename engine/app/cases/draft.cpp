#include "engine/app/cases/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "haptics/solid.h"

namespace typodont {

namespace {

/// Number of pieces of the tissue `which`; the voxels of a piece are connected by faces. kAir: pieces of all tissue.
int pieces(const haptics::DenseTissue& tissue, Tissue which) {
  const auto in = [&](std::size_t i) {
    return tissue.distance[i] < 0 && (which == Tissue::kAir || tissue.tissue[i] == which);
  };
  std::vector<bool> seen(tissue.tissue.size());
  std::vector<std::size_t> stack;
  const std::size_t step[3] = {tissue.at(1, 0, 0), tissue.at(0, 1, 0), 1};
  int count = 0;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first] || !in(first)) continue;
    ++count;
    seen[first] = true;
    // Air surrounds the tooth, so the six neighbours of each voxel of the tooth are inside the grid.
    for (stack.assign(1, first); !stack.empty();) {
      const std::size_t i = stack.back();
      stack.pop_back();
      for (const std::size_t s : step)
        for (const std::size_t j : {i - s, i + s})
          if (!seen[j] && in(j)) seen[j] = true, stack.push_back(j);
    }
  }
  return count;
}

}  // namespace

double in_mm(double metres) {
  return std::round(metres / kMillimetre * 1e4) * 1e-4;
}

double Lesion::hardness(const dvec3& p) const {
  const dvec3 local = glm::transpose(R) * p;
  const glm::dvec2 q(local), along = b - a;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0 ? std::clamp(glm::dot(q - a, along) / length2, 0.0, 1.0) : 0;
  const double beside = glm::length(q - a - t * along), down = top - local.z;
  if (down > depth) return 0;
  if (down < border) return beside < glm::mix(opening, width, std::max(down, 0.0) / border) ? 0.3 : 0;
  const double s = (down - border) / (depth - border);
  // Caries: softest at the enamel-dentin border (Knoop hardness by ICDAS code: Shimizu, Dent Mater J 34 (2015) 252).
  return s >= 0 && beside < width * std::sqrt(1 - s * s) ? 0.15 + 0.45 * s : 0;
}

void Draft::lay_down(const dvec3& opening) {
  const double side = R[2].y > 0 ? 1 : -1;
  turn = {{side, 0, 0}, {0, 0, side}, {0, -1, 0}};
  offset = kTop - turn * R * opening;
}

Ordered Draft::direction(const dvec3& d) const {
  const dvec3 to = turn * R * d;
  return {to.x, to.y, to.z};
}

Ordered Draft::point(const dvec3& p) const {
  const dvec3 q = to_W(p);
  return {in_mm(q.x), in_mm(q.y), in_mm(q.z)};
}

Ordered Draft::halfspace(const dvec3& normal, const dvec3& on) const {
  return {{"halfspace", {{"normal", direction(normal)}, {"offset_mm", in_mm(glm::dot(turn * R * normal, to_W(on)))}}}};
}

Ordered Draft::shaft(const glm::dvec2& at, double floor, double radius) const {
  const double height = above() - floor;
  Ordered solid = {{"center_mm", point({at.x, at.y, floor + 0.5 * height})},
                   {"axis", direction({0, 0, 1})},
                   {"radius_mm", radius / kMillimetre},
                   {"height_mm", height / kMillimetre}};
  if (lean == 0) return {{"cylinder", solid}};
  solid["top_radius_mm"] = in_mm(radius + height * std::tan(lean));
  return {{"cone", solid}};
}

Ordered Draft::block(const glm::dvec2& a, const glm::dvec2& b, double floor, double width, bool end_leans) const {
  const glm::dvec2 t = glm::normalize(b - a);
  const dvec3 along(t, 0), across(-t.y, t.x, 0), low(a, floor), high(b, above());
  const auto leaning = [&](const dvec3& outward) { return std::cos(lean) * outward - dvec3(0, 0, std::sin(lean)); };
  return {
      {"intersection",
       {halfspace(along, high), halfspace(end_leans ? leaning(-along) : -along, low),
        halfspace(leaning(across), low + 0.5 * width * across), halfspace(leaning(-across), low - 0.5 * width * across),
        halfspace({0, 0, 1}, high), halfspace({0, 0, -1}, low)}}};
}

void Draft::slot(const glm::dvec2& a, const glm::dvec2& b, double floor, double width) {
  ideal["remove"].push_back(block(a, b, floor, width));
  for (const glm::dvec2& end : {a, b}) ideal["remove"].push_back(shaft(end, floor, 0.5 * width));
}

void Draft::box(double side, double axial, double middle, double width, double floor) {
  const double end = side * (0.5 * out.tooth.md + 1e-3), inner = axial + side * kCorner;
  ideal["remove"].push_back(block({inner, middle}, {end, middle}, floor, width));
  ideal["remove"].push_back(block({axial, middle}, {end, middle}, floor, width - 2 * kCorner, /*end_leans=*/true));
  for (const double edge : {-1.0, 1.0})
    ideal["remove"].push_back(shaft({inner, middle + edge * (0.5 * width - kCorner)}, floor, kCorner));
}

void Draft::add_neighbour(double side) {
  const CaseTooth& tooth = out.tooth;
  const dvec3 contact(side * 0.5 * tooth.md, -tooth.form.lean * tooth.form.proximal, tooth.form.proximal);
  neighbours.push_back({{"contact_mm", point(glm::transpose(R) * contact)}});
}

double Draft::surface(const glm::dvec2& at) const {
  double w = above();
  while (w > 0 && out.tooth.distance(R * dvec3(at, w)) > 0) w -= 0.02e-3;
  return w;
}

double enamel_depth(const CaseTooth& tooth, const dvec3& p, const dvec3& down) {
  double depth = 0;
  while (depth < 3e-3 && tooth.tissue(p + (depth + 1e-5) * down) == Tissue::kEnamel) depth += 0.05e-3;
  return depth;
}

void apply_lesions(Draft& draft) {
  haptics::DenseTissue& tissue = draft.tissue;
  const auto filling = haptics::read_solid_list(Json::parse(draft.filling.dump(), "filling").items());
  const Tissue filled = filling.empty() ? Tissue::kAir : haptics::read_tissue_name(draft.family["filled"]);
  if (draft.lesions.empty() && filling.empty()) return;
  if (!draft.lesions.empty()) tissue.hardness.assign(tissue.tissue.size(), haptics::kOwnHardness);
  for (int x = 0; x < tissue.size.x; ++x)
    for (int y = 0; y < tissue.size.y; ++y)
      for (int z = 0; z < tissue.size.z; ++z) {
        const std::size_t i = tissue.at(x, y, z);
        if (tissue.tissue[i] != Tissue::kEnamel && tissue.tissue[i] != Tissue::kDentin) continue;
        const dvec3 p = tissue.frame.to_world(dvec3(x, y, z));
        const dvec3 p_W = draft.turn * p + draft.offset;
        if (std::ranges::any_of(filling, [&](const auto& solid) { return solid->distance(p_W) <= 0; })) {
          tissue.tissue[i] = filled;
          continue;
        }
        for (const Lesion& lesion : draft.lesions) {
          const double hardness = lesion.hardness(p);
          if (hardness == 0) continue;
          tissue.tissue[i] = Tissue::kCaries;
          tissue.hardness[i] = haptics::hardness_byte(hardness);
        }
      }
}

haptics::DenseTissue turned(const haptics::DenseTissue& tissue, const glm::dmat3& turn) {
  haptics::DenseTissue out = tissue;
  const dvec3 a = turn * tissue.frame.to_world(dvec3(0)), b = turn * tissue.frame.to_world(dvec3(tissue.size - 1));
  out.frame.origin = glm::min(a, b);
  out.size = glm::ivec3(glm::round(glm::abs(b - a) / tissue.frame.voxel)) + 1;
  for (int x = 0; x < out.size.x; ++x)
    for (int y = 0; y < out.size.y; ++y)
      for (int z = 0; z < out.size.z; ++z) {
        const dvec3 p = glm::transpose(turn) * out.frame.to_world(dvec3(x, y, z));
        const glm::ivec3 v(glm::round(tissue.frame.to_voxels(p)));
        const std::size_t from = tissue.at(v.x, v.y, v.z), to = out.at(x, y, z);
        out.distance[to] = tissue.distance[from];
        out.tissue[to] = tissue.tissue[from];
        if (!tissue.hardness.empty()) out.hardness[to] = tissue.hardness[from];
      }
  return out;
}

void check_tissue(const Draft& draft) {
  const haptics::DenseTissue& tissue = draft.tissue;
  if (const int n = pieces(tissue, Tissue::kAir); n != 1) throw RunFailure(fmt::format("the tooth has {} pieces", n));
  double cover = 1;
  // A scanned pulp is open at the apices, so only the crown counts.
  const auto rows = static_cast<std::size_t>(tissue.size.z);
  const auto first =
      static_cast<std::size_t>(draft.out.tooth.scan ? std::max(0.0, tissue.frame.to_voxels(dvec3(0)).z) : 0.0);
  for (std::size_t i = 0; i < tissue.tissue.size(); ++i)
    if (tissue.tissue[i] == Tissue::kPulp && tissue.distance[i] > -tissue.band && i % rows >= first)
      cover = std::min(cover, -static_cast<double>(tissue.distance[i]));
  if (cover < 0.2e-3) throw RunFailure(fmt::format("only {:.2f} mm of tissue around the pulp", cover / kMillimetre));
  if (draft.lesions.empty()) return;
  if (const int n = pieces(tissue, Tissue::kCaries); n != static_cast<int>(draft.lesions.size()))
    throw RunFailure(fmt::format("{} lesions have {} pieces", draft.lesions.size(), n));
}

}  // namespace typodont
