#include "engine/app/cases/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/nearest.h"
#include "engine/base/voxels.h"
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

// Least depth of the lesions of each ICDAS code; last: largest depth of code 6. 1: the border of enamel and dentin, 2:
// the pulp. Code 1: outer half of the enamel, 2: inner half (Ekstrand criteria); 3, 4: outer and middle third of the
// dentin; 5, 6: inner third (radiographic classes, BMC Oral Health 15 (2015) S3; their order by code: estimate).
constexpr std::array kIcdasReach{0.25, 0.5, 1.0, 4 / 3.0, 5 / 3.0, 1.8, 1.95};

struct IcdasHardness {
  double enamel, dentin;  // caries, on the lesion's axis: at the surface and at the border to dentin
  double white_spot;      // enamel beside the lesion
};
// Enamel has 0.7, 0.51 and 0.1 of its Knoop hardness at the codes 1 to 3 (Shimizu, Dent Mater J 34 (2015) 252). The
// material caries has 0.3 of enamel's stiffness, so 0.1 is a third of it, and the codes 1 and 2 get its largest value.
// From code 5 on, the enamel has broken down; dentin: estimate.
constexpr std::array<IcdasHardness, 6> kIcdasHardness{{{0.9, 0.9, 0.7},
                                                       {0.9, 0.75, 0.51},
                                                       {0.34, 0.34, 0.51},
                                                       {0.34, 0.25, 0.51},
                                                       {0.15, 0.2, 0.51},
                                                       {0.15, 0.15, 0.51}}};
// m, radius of the sphere through all cusps, to whose middle the teeth point (Monson), which gives the curves of Spee
// and Wilson; half the width of the arch at the first molars (lower 51.7 mm, upper 53.8 mm: casts of 76 people).
constexpr double kMonson = 101.6e-3, kHalfArch = 26.4e-3;
constexpr double kRimHardness = 0.9;     // caries at its edge
constexpr double kAffectedDentin = 0.6;  // dentin at the edge of caries; estimate

/// The point of the crown's surface that is farthest along n, m; n is nearly along the arch.
dvec3 farthest(const CaseTooth& tooth, const dvec3& n) {
  constexpr double kStep = 0.2e-3, kNear = 1e-6;  // m
  const double side = n.x > 0 ? 1 : -1;
  dvec3 best(0);
  for (double y = -0.5 * tooth.bl; y < 0.5 * tooth.bl; y += kStep)
    for (double z = 0; z < tooth.crown; z += kStep) {
      dvec3 p(side * (0.5 * tooth.md + 1e-3), y, z);
      for (double d = 1; d > kNear && p.x * side > 0; p.x -= side * 0.7 * d) d = tooth.distance(p);
      if (p.x * side > 0 && glm::dot(p, n) > glm::dot(best, n)) best = p;
    }
  return best;
}

}  // namespace

double in_mm(double metres) {
  return std::round(metres / kMillimetre * 1e4) * 1e-4;
}

Lesion::Point Lesion::at(const dvec3& p, Tissue sound) const {
  const dvec3 local = glm::transpose(R) * p;
  const double beside = distance_to_segment(a, b, glm::dvec2(local)), down = std::max(top - local.z, 0.0);
  const IcdasHardness& soft = kIcdasHardness[static_cast<std::size_t>(icdas - 1)];
  double rho = 0, outside = 0, core = soft.dentin;  // rho: 0 on the axis, 1 at the edge; outside: m
  if (down < border) {
    const double radius = glm::mix(opening, width, down / border);
    rho = beside / radius;
    outside = beside - radius;
    core = glm::mix(soft.enamel, soft.dentin, down / border);
  } else {
    const double deep = depth - border;
    rho = deep > 0 ? std::hypot(beside / width, (down - border) / deep) : 1;
    outside = std::max({(rho - 1) * std::min(width, deep), beside - width, down - depth});
  }
  if (outside < 0) return {Tissue::kCaries, glm::mix(core, kRimHardness, rho * rho)};
  if (outside >= affected || local.z > top + affected) return {sound, 1};
  const double least = sound == Tissue::kEnamel ? soft.white_spot : kAffectedDentin;
  return {sound, glm::mix(least, 1.0, outside / affected)};
}

double lesion_depth(int icdas, double within, const Layers& layers) {
  const auto code = static_cast<std::size_t>(icdas);
  const double reach = glm::mix(kIcdasReach[code - 1], kIcdasReach[code], within);
  return layers.enamel * std::min(reach, 1.0) + layers.dentin * std::max(reach - 1, 0.0);
}

int icdas_of(double depth, const Layers& layers) {
  int code = 1;
  while (code < 6 && depth > lesion_depth(code, 1, layers)) ++code;
  return code;
}

void Draft::lay_down(const dvec3& opening) {
  const double side = R[2].y > 0 ? 1 : -1;
  turn = {{side, 0, 0}, {0, 0, side}, {0, -1, 0}};
  offset = kTop - turn * R * opening;
}

void Draft::cover_with_gum(double margin) {
  const glm::dmat3 to_local = glm::transpose(R);
  surroundings = {{"crown", direction(to_local * dvec3(0, 0, 1))},
                  {"arch", direction(to_local * dvec3(1, 0, 0))},
                  {"monitored", false},
                  {"gum",
                   {{"margin_mm", point(to_local * dvec3(0, 0, margin))},
                    {"length_mm", in_mm(out.tooth.md + 4e-3)},
                    {"papilla_mm", 1}}}};
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
  dvec3 n(side, 0, 0);
  // As far beyond the surface as half the stated width of the crown, which the rounded crown may miss a little.
  const double gap = 0.5 * tooth.md - side * farthest(tooth, n).x;
  if (tooth.type[1] > '3') {
    const double up = tooth.type[0] == 'L' ? 1 : -1, lingual = std::asin(kHalfArch / kMonson);
    const dvec3 middle(0, 0, tooth.crown + up * kMonson), across(0, std::cos(lingual), -up * std::sin(lingual));
    const dvec3 widest(side * 0.5 * tooth.md, -tooth.form.lean * tooth.form.proximal, tooth.form.proximal);
    n = -side * up * glm::normalize(glm::cross(across, widest - middle));
  }
  const dvec3 contact = farthest(tooth, n) + gap * n;
  surroundings["neighbours"].push_back(
      {{"contact_mm", point(glm::transpose(R) * contact)}, {"normal", direction(glm::transpose(R) * n)}});
}

double Draft::surface(const glm::dvec2& at) const {
  double w = above();
  while (w > 0 && out.tooth.distance(R * dvec3(at, w)) > 0) w -= 0.02e-3;
  return w;
}

Layers layers_below(const CaseTooth& tooth, const dvec3& p, const dvec3& down) {
  constexpr double kStep = 0.05e-3, kMost = 10e-3;  // m
  Layers layers;
  while (layers.enamel < 3e-3 && tooth.tissue(p + (layers.enamel + 1e-5) * down) == Tissue::kEnamel)
    layers.enamel += kStep;
  double nearest = kMost;
  for (double dentin = 0; dentin < kMost && nearest > 0; dentin += kStep)
    if (const double pulp = tooth.pulp_distance(p + (layers.enamel + dentin) * down); pulp < nearest)
      nearest = pulp, layers.dentin = dentin;
  return layers;
}

Lesion& Draft::add_lesion(Lesion lesion, double deepest) {
  const dvec3 from = lesion.R * dvec3(0.5 * (lesion.a + lesion.b), lesion.top);
  const Layers layers = layers_below(out.tooth, from, -lesion.R[2]);
  double& code = out.parameters.at("icdas");
  lesion.depth = std::min(lesion_depth(static_cast<int>(std::lround(code)), uniform(random), layers), deepest);
  lesion.icdas = icdas_of(lesion.depth, layers);
  lesion.border = std::min(layers.enamel, lesion.depth);
  code = lesion.icdas;
  out.parameters["lesion_depth_mm"] = lesion.depth / kMillimetre;
  return lesions.emplace_back(lesion);
}

void apply_lesions(Draft& draft) {
  haptics::DenseTissue& tissue = draft.tissue;
  const auto filling = haptics::read_solid_list(Json::parse(draft.filling.dump(), "filling").items());
  const Tissue filled = filling.empty() ? Tissue::kAir : haptics::read_tissue_name(draft.family["filled"]);
  if (draft.lesions.empty() && filling.empty()) return;
  if (!draft.lesions.empty()) tissue.hardness.assign(tissue.tissue.size(), haptics::kOwnHardness);
  for_each_voxel(tissue.size, [&](int x, int y, int z) {
    const std::size_t i = tissue.at(x, y, z);
    if (tissue.tissue[i] != Tissue::kEnamel && tissue.tissue[i] != Tissue::kDentin) return;
    const dvec3 p = tissue.frame.to_world(dvec3(x, y, z));
    const dvec3 p_W = draft.turn * p + draft.offset;
    if (std::ranges::any_of(filling, [&](const auto& solid) { return solid->distance(p_W) <= 0; })) {
      tissue.tissue[i] = filled;
      return;
    }
    const Tissue sound = tissue.tissue[i];
    for (const Lesion& lesion : draft.lesions) {
      const Lesion::Point here = lesion.at(p, sound);
      const std::uint8_t hardness = haptics::hardness_byte(here.hardness);
      if (here.tissue == Tissue::kCaries) tissue.tissue[i] = Tissue::kCaries;
      tissue.hardness[i] = std::min(tissue.hardness[i], hardness);
    }
  });
}

haptics::DenseTissue turned(const haptics::DenseTissue& tissue, const glm::dmat3& turn) {
  haptics::DenseTissue out = tissue;
  const dvec3 a = turn * tissue.frame.to_world(dvec3(0)), b = turn * tissue.frame.to_world(dvec3(tissue.size - 1));
  out.frame.origin = glm::min(a, b);
  out.size = glm::ivec3(glm::round(glm::abs(b - a) / tissue.frame.voxel)) + 1;
  for_each_voxel(out.size, [&](int x, int y, int z) {
    const dvec3 p = glm::transpose(turn) * out.frame.to_world(dvec3(x, y, z));
    const glm::ivec3 v(glm::round(tissue.frame.to_voxels(p)));
    const std::size_t from = tissue.at(v.x, v.y, v.z), to = out.at(x, y, z);
    out.distance[to] = tissue.distance[from];
    out.tissue[to] = tissue.tissue[from];
    if (!tissue.hardness.empty()) out.hardness[to] = tissue.hardness[from];
  });
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
