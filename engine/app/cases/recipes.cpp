// The recipes of case families: each composes a cavity, a lesion or a preparation from slots, boxes and planes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "engine/app/cases/draft.h"
#include "engine/app/tissue/blend.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr double kBelowRoof = 1e-3;    // m, depth of a narrow access below the chamber's roof
constexpr double kNarrowest = 1.3e-3;  // m; an access is never narrower than this, so that a bur of 1.2 mm can cut it
constexpr double kNarrowestMolar = 1.45e-3;  // m, the same for the deeper access of a molar
constexpr double kInside = 0.15e-3;          // m, a lesion ends this far inside the cavity that removes it
constexpr double kAround = 0.08e-3;          // m, the trough for recurrent caries is wider than the lesion
constexpr double kBelowContact = 0.6e-3;     // m, centre of an approximal lesion below the middle of the contact
constexpr double kApart = 2e-3;              // m, smallest distance of two lesions that the trainee must find

/// Unit vector out of the tooth at a point of its surface.
dvec3 outward(const CaseTooth& tooth, const dvec3& p) {
  return glm::normalize(central_difference(std::bind_front(&CaseTooth::distance, &tooth), p, 0.1e-3));
}

/// Half the length of the cavity's outline, m. 1.8 mm of the marginal ridges remain (rubric rcampus PX4C443: 1.5 to 2
/// mm).
double half_outline(const CaseTooth& tooth) {
  return std::min(0.5 * tooth.md - 1.8e-3, 0.24 * tooth.md + 0.2e-3);
}

/// An old filling of the cavity's shape, and recurrent caries below its floor, from the slot's end `a` towards `b`.
void old_filling(Draft& draft, const glm::dvec2& a, const glm::dvec2& b, double floor, double width) {
  draft.filling = draft.ideal["remove"];
  if (!draft.has("recurrent_mm")) return;
  Lesion lesion{draft.R, a, glm::mix(a, b, 0.4), floor};
  lesion.border = 0.05e-3;
  lesion.depth = draft.mm("recurrent_mm");
  lesion.opening = lesion.width = 0.4 * width;
  for (const glm::dvec2& at : {lesion.a, lesion.b})
    if (const double left = draft.out.tooth.pulp_distance({at, floor - lesion.depth}); left < draft.mm("pulp_left_mm"))
      throw RunFailure(fmt::format("the recurrent caries would end {:.2f} mm from the pulp", left / kMillimetre));
  draft.lesions.push_back(lesion);
  // A trough around the lesion for a round bur: its cross-section is a circle through the lesion's rim and end.
  const double rim = lesion.width + kAround, deep = lesion.depth + kAround;
  const double radius = 0.5 * (rim * rim + deep * deep) / deep, middle = floor - deep + radius;
  draft.ideal["remove"].push_back({{"capsule",
                                    {{"a_mm", draft.point({lesion.a, middle})},
                                     {"b_mm", draft.point({lesion.b, middle})},
                                     {"radius_mm", in_mm(radius)}}}});
}

void fissure(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const double width = draft.mm("isthmus_mm"), reach = half_outline(tooth) - 0.5 * width;
  const glm::dvec2 a(-reach, tooth.fissure(-reach)), b(reach, tooth.fissure(reach));
  double surface = 0;
  constexpr int kAlong = 20, kAcross = 4;
  for (int i = 0; i <= kAlong; ++i)
    for (int j = -kAcross; j <= kAcross; ++j) {
      const glm::dvec2 p = glm::mix(a, b, i / double(kAlong));
      surface += tooth.surface(p.x, p.y + 0.5 * width * j / kAcross) / ((kAlong + 1) * (2 * kAcross + 1));
    }
  const double floor = surface - draft.mm("depth_mm");
  draft.slot(a, b, floor, width);
  draft.out.parameters["length_mm"] = (2 * reach + width) / kMillimetre;
  if (draft.family.has("filled")) {
    const bool mesial = uniform(draft.random) < 0.5;
    old_filling(draft, mesial ? b : a, mesial ? a : b, floor, width);
  }
  if (!draft.has("icdas")) return;
  const glm::dvec2 middle = 0.5 * (a + b);
  Lesion lesion{draft.R, glm::mix(middle, a, 0.6), glm::mix(middle, b, 0.6),
                tooth.surface(middle.x, tooth.fissure(middle.x))};
  lesion.opening = 0.12e-3;
  lesion.width = 0.3 * width;
  draft.add_lesion(lesion, lesion.top - floor - kInside);
}

void lesion(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const glm::dvec2 at(0, tooth.fissure(0));
  const double top = tooth.surface(at.x, at.y);
  double deepest = 0;  // m below the top, limit of the lesion's depth; grows until the pulp is too near
  while (deepest < 8e-3 && tooth.pulp_distance({at.x, at.y, top - deepest}) > draft.mm("pulp_left_mm"))
    deepest += 0.02e-3;
  Lesion wanted{draft.R, at, at, top};
  wanted.opening = 0.3e-3;
  wanted.width = 0.5 * draft.mm("lesion_width_mm");
  Lesion& lesion = draft.add_lesion(wanted, deepest);
  lesion.border += 0.1e-3;
  if (lesion.depth < lesion.border + 0.5e-3)
    throw RunFailure(fmt::format("only {:.2f} mm of dentin for a lesion that ends {:.2f} mm from the pulp",
                                 (deepest - lesion.border) / kMillimetre, draft.mm("pulp_left_mm") / kMillimetre));
  draft.out.parameters["pulp_left_mm"] = tooth.pulp_distance({at.x, at.y, top - lesion.depth}) / kMillimetre;
  draft.ideal = {{"remove_tissue", {"caries"}}, {"grow_mm", 0.12}};
  draft.ideal["remove"].push_back(draft.shaft(at, lesion.top - lesion.border, lesion.width));
  if (draft.has("caries_left_mm"))
    draft.ideal["keep"].push_back(
        draft.halfspace({0, 0, 1}, {at, lesion.top - lesion.depth + draft.mm("caries_left_mm")}));
}

void access(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  // The slot is as wide as the pulp at half the chamber's height; in a premolar, at 1 mm below the chamber's roof.
  const bool molar = tooth.type[1] >= '6';
  const double z = molar ? 0.5 * (tooth.chamber_roof + tooth.chamber_floor) : tooth.chamber_roof - kBelowRoof;
  const auto half = [&](const dvec3& along) {
    double reach = 0;
    while (reach < 4e-3 && tooth.pulp_distance(dvec3(0, 0, z) + reach * along) < 0) reach += 0.02e-3;
    return reach;
  };
  const double x = half({1, 0, 0}), y = half({0, 1, 0});
  const double width = std::max(2 * std::min(x, y), molar ? kNarrowestMolar : kNarrowest);
  const double reach = std::max(std::max(x, y) - 0.5 * width, 0.3e-3);
  const glm::dvec2 end = x > y ? glm::dvec2(reach, 0) : glm::dvec2(0, reach);
  draft.slot(-end, end, z, width);
}

/// Adds a slot through the lingual surface at 45° to the tooth's axis. It ends 1 mm below the roof of the pulp chamber.
void lingual_access(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  draft.approach_along({0, -std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2});
  const dvec3 end = glm::transpose(draft.R) * dvec3(0, 0, tooth.chamber_roof - kBelowRoof);
  draft.slot({-0.4e-3, end.y}, {0.4e-3, end.y}, end.z, kNarrowest);
}

/// Caries of the surface that faces a neighbour, below the contact: a cone in enamel, round in dentin. It ends before
/// the box's axial wall at u = `axial`.
void approximal_caries(Draft& draft, double side, double axial, double middle) {
  const CaseTooth& tooth = draft.out.tooth;
  const dvec3 out(side, 0, 0);
  Lesion lesion{{{0, 1, 0}, {0, 0, side}, out}};
  const double z = tooth.form.proximal - kBelowContact;
  lesion.a = lesion.b = {middle, side * z};
  lesion.top = 0.5 * tooth.md + 0.5e-3;
  while (tooth.distance({side * lesion.top, middle, z}) > 0) lesion.top -= 0.02e-3;
  lesion.opening = 0.65e-3;
  lesion.width = 0.6e-3;
  Lesion& made = draft.add_lesion(lesion, lesion.top - std::abs(axial) - kInside);
  if (made.border == made.depth) made.width = 0.2e-3;  // the cone's tip is in enamel
}

/// Adds the cavity: a slot along the fissure (unless the family says "occlusal": false), and a box towards each
/// neighbouring tooth.
void boxes(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const bool occlusal = draft.family.boolean_or("occlusal", true);
  if (draft.has("wall_deg")) draft.lean = glm::radians(draft.out.parameters.at("wall_deg"));
  const double width = occlusal ? draft.mm("isthmus_mm") : 0, reach = half_outline(tooth) - 0.5 * width;
  const double gingival = tooth.form.proximal - draft.mm("clearance_mm");
  const double floor = occlusal ? tooth.surface(0, tooth.fissure(0)) - draft.mm("depth_mm") : gingival + 1e-3;
  if (gingival > floor - 0.4e-3 || gingival < std::max(tooth.cej_mesial, tooth.cej_distal) + 0.5e-3)
    throw RunFailure(
        fmt::format("the gingival floor would be {:.2f} mm below the pulpal floor and {:.2f} mm above the "
                    "neck",
                    (floor - gingival) / kMillimetre, gingival / kMillimetre));
  glm::dvec2 ends[2] = {{-reach, tooth.fissure(-reach)}, {reach, tooth.fissure(reach)}};
  for (const Json& which : draft.family["boxes"].items()) {
    const double side = which.number(-1, 1), axial = side * (0.5 * tooth.md - draft.mm("axial_mm"));
    glm::dvec2& end = ends[side > 0];
    draft.box(side, axial, end.y, draft.mm("box_width_mm"), gingival);
    if (draft.has("icdas")) approximal_caries(draft, side, axial, end.y);
    end.x = axial + side * kCorner;  // the slot ends inside the box
    draft.add_neighbour(side);
  }
  if (occlusal) draft.slot(ends[0], ends[1], floor, width);
  if (draft.family.has("filled")) old_filling(draft, ends[0], ends[1], floor, width);
}

/// An inlay whose functional cusps (lower: buccal, upper: lingual) are lowered to a flat table.
void onlay(Draft& draft) {
  boxes(draft);
  const CaseTooth& tooth = draft.out.tooth;
  const double side = tooth.type[0] == 'L' ? 1 : -1;
  double lowest = tooth.crown;
  for (const ToothHill& hill : tooth.form.hills)
    if (hill.at.y * side > 0 && hill.is_cusp() && hill.height > 0.83 * tooth.crown)
      lowest = std::min(lowest, hill.height);
  const dvec3 on(0, tooth.fissure(0), lowest - draft.mm("cusp_mm"));
  draft.ideal["remove"].push_back(
      {{"intersection", {draft.halfspace({0, -side, 0}, on), draft.halfspace({0, 0, -1}, on)}}});
}

/// Box-shaped cavity between front teeth, cut from the lingual side; the labial wall remains.
void lingual_box(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  draft.approach_along({0, -1, 0});  // axis v points out of the crown
  const double middle = tooth.form.proximal - draft.mm("below_contact_mm"), height = draft.mm("height_mm");
  const double axial = 0.5 * tooth.md - draft.mm("axial_mm");
  double labial = 0;
  while (tooth.distance({axial, labial, middle}) < 0) labial += 0.02e-3;
  draft.box(1, axial, middle, height, draft.mm("labial_wall_mm") - labial);
  draft.add_neighbour(1);
}

/// Adds a slot in the buccal surface. In its middle, the slot has the depth "depth_mm"; "above_neck_mm" is the height
/// of its lower edge, negative on the root.
void cervical(Draft& draft) {
  draft.approach_along({0, 1, 0});  // axis v points towards the root
  const double width = draft.mm("height_mm"), reach = 0.5 * (draft.mm("length_mm") - width);
  const double v = -draft.mm("above_neck_mm") - 0.5 * width;
  const double top = draft.surface({0, v}), floor = top - draft.mm("depth_mm");
  draft.lay_down({0, v, top});
  draft.slot({-reach, v}, {reach, v}, floor, width);
  Lesion lesion{draft.R, {-0.5 * reach, v}, {0.5 * reach, v}, top};
  const bool pit = draft.family.boolean_or("pit", false);  // a pit's entrance is narrow, a smooth surface's wide
  lesion.opening = (pit ? 0.25 : 0.4) * width;
  lesion.width = 0.4 * width;
  const double deepest = draft.mm("depth_mm") - kInside;
  if (draft.mm("above_neck_mm") > 0) {
    draft.add_lesion(lesion, deepest);
    return;
  }
  // A root has its own codes: 1 discoloured, 2 with a cavity.
  double& code = draft.out.parameters.at("icdas");
  code = static_cast<double>(std::lround(code));
  lesion.icdas = code < 2 ? 3 : 5;
  lesion.depth = deepest;
  draft.lesions.push_back(lesion);
}

void crown(Draft& draft) {
  const auto& have = draft.out.parameters;
  draft.ideal["crown"] = {{"margin_mm", in_mm(draft.mm("above_neck_mm") + draft.offset.z)},
                          {"chamfer_mm", have.at("chamfer_mm")},
                          {"chamfer_radius_mm", 1.15},
                          {"taper_deg", have.at("taper_deg")},
                          {"occlusal_mm", have.at("occlusal_mm")},
                          {"edge_radius_mm", 0.6}};
}

/// A broken mesial corner of an incisor; the ideal bevels the labial enamel along the fracture.
void fracture(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  draft.approach_along({0, 1, 0});
  draft.show_buccal_side();
  const glm::dmat3 to_local = glm::transpose(draft.R);
  const double angle = glm::radians(draft.out.parameters.at("fracture_deg")), bevel = draft.mm("bevel_mm");
  const dvec3 n(std::sin(angle), 0, std::cos(angle)), along(std::cos(angle), 0, -std::sin(angle));
  const dvec3 edge(0.5 * tooth.md - draft.mm("loss_mm"), 0, tooth.crown);
  draft.prepare.push_back(draft.halfspace(to_local * -n, to_local * edge));
  draft.add_neighbour(1);
  constexpr double kStep = 0.4e-3, kTilt = 35;  // m, width of a facet of the bevel; degrees, bevel to the enamel
  for (double e = 0; e < tooth.crown; e += kStep) {
    dvec3 p = edge + (e + 0.5 * kStep) * along - bevel * n;
    p.y = 0.5 * tooth.bl;
    while (p.y > 0 && tooth.distance(p) > 0) p.y -= 0.02e-3;
    if (p.y <= 0) continue;
    const dvec3 normal = outward(tooth, p), slope = glm::normalize(normal - glm::dot(normal, n) * n);
    const dvec3 out = std::cos(glm::radians(kTilt)) * slope + std::sin(glm::radians(kTilt)) * n;
    const dvec3 from = edge + e * along, to = from + kStep * along;
    draft.ideal["remove"].push_back(
        {{"intersection",
          {draft.halfspace(to_local * -out, to_local * p), draft.halfspace(to_local * along, to_local * to),
           draft.halfspace(to_local * -along, to_local * from)}}});
  }
}

/// Calculus at the neck: rows of overlapping balls, on the lingual side of lower teeth and the buccal side of upper
/// teeth, where the ducts of the salivary glands open. The gum hides the calculus below its margin.
void calculus(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  draft.approach_along({0, tooth.type[0] == 'U' ? 1.0 : -1.0, 0});
  const double top = draft.mm("above_neck_mm"), bottom = -draft.mm("below_neck_mm"), out = draft.R[1].z;
  const double middle = out * 0.5 * (top + bottom);
  draft.lay_down({0, middle, draft.surface({0, middle})});
  const auto pieces = std::lround(draft.out.parameters.at("pieces"));
  draft.out.parameters["pieces"] = static_cast<double>(pieces);
  const double reach = 0.3 * tooth.md, room = 2 * reach / static_cast<double>(pieces);
  constexpr int kBalls = 6;
  constexpr double kCovered = 0.6;  // part of each piece's room between its first and its last ball
  Ordered rows = Ordered::array();
  for (long piece = 0; piece < pieces; ++piece) {
    dvec3 last(0);
    for (int k = 0; k < kBalls; ++k) {
      const double u = -reach + room * (static_cast<double>(piece) + 0.5 + kCovered * (k / (kBalls - 1.0) - 0.5));
      const double v = out * glm::mix(bottom, top, uniform(draft.random));
      const double thick = draft.mm("thickness_mm") * (0.7 + 0.3 * uniform(draft.random)), radius = thick + 0.4e-3;
      const dvec3 on(u, v, draft.surface({u, v}));
      const dvec3 center = on + (thick - radius) * (glm::transpose(draft.R) * outward(tooth, draft.R * on));
      if (k > 0)
        rows.push_back(
            {{"capsule", {{"a_mm", draft.point(last)}, {"b_mm", draft.point(center)}, {"radius_mm", in_mm(radius)}}}});
      last = center;
    }
  }
  draft.prepare.push_back({{"tissue", "composite"}, {"solid", {{"union", rows}}}});
  draft.cover_with_gum(kFreeGum);
  draft.ideal = {{"unprepared", true}};
}

/// Caries of the occlusal surface that looks like sound enamel; the trainee finds it. Distal and mesial in turn.
void hidden_caries(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const glm::dvec2 half(0.3 * tooth.md, 0.24 * tooth.bl);
  const auto count = static_cast<std::size_t>(std::lround(draft.out.parameters.at("lesions")));
  draft.out.parameters["lesions"] = static_cast<double>(count);
  constexpr int kTries = 1000;
  for (int tries = 0; draft.lesions.size() < count && tries < kTries; ++tries) {
    const double side = draft.lesions.size() % 2 == 0 ? -1 : 1;
    glm::dvec2 at(side * half.x * uniform(draft.random), half.y * (2 * uniform(draft.random) - 1));
    if (uniform(draft.random) < 0.5) at.y = tooth.fissure(at.x);
    if (std::abs(at.x) < 0.5 * kApart) continue;
    if (std::ranges::any_of(draft.lesions, [&](const Lesion& l) { return glm::length(l.a - at) < kApart; })) continue;
    Lesion lesion{draft.R, at, at, tooth.surface(at.x, at.y)};
    lesion.depth = 1.2e-3;
    lesion.border = 0.9 * lesion.depth;
    lesion.opening = lesion.width = 0.5 * draft.mm("lesion_width_mm");
    lesion.icdas = 3;
    lesion.affected = 0;  // a white rim would show the lesion
    draft.lesions.push_back(lesion);
  }
  if (draft.lesions.size() < count) throw RunFailure(fmt::format("no room for {} lesions", count));
  const dvec3 middle(0, 0, tooth.crown - 1.5e-3);
  draft.explore["region"].push_back(
      {{"box", {{"center_mm", draft.point(middle)}, {"size_mm", {in_mm(2.4 * half.x), in_mm(2.4 * half.y), 4.5}}}}});
}

/// Gum with a pocket at each of six sites: mesial, middle and distal on the buccal and the lingual side. In a molar,
/// the middle ones stay above the furcation.
void pockets(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  constexpr std::size_t kSites = 6;
  constexpr double kHealthy = 1.83e-3, kHealthySd = 0.5e-3;  // m, depth of a healthy sulcus: mean, deviation
  constexpr double kPocketFrom = 4e-3;                       // m, depth from which a sulcus is a pocket
  constexpr double kAboveFurcation = 1e-3;                   // m
  constexpr double kNeckBelowTop = 4e-3;                     // m; the gum's margin is in view
  draft.offset.z = kTop.z - kNeckBelowTop;
  const std::vector<Json> names = draft.family["sites"].items();
  std::array<double, kSites> depth;
  for (double& d : depth) d = std::clamp(kHealthy + kHealthySd * normal(draft.random), 1e-3, 3e-3);
  const auto count = static_cast<std::size_t>(std::lround(draft.out.parameters.at("pockets")));
  draft.out.parameters["pockets"] = static_cast<double>(count);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < kSites; ++i)
    if (i % 3 != 1 || tooth.furcation == 0) places.push_back(i);
  for (std::size_t k = 0; k < count && !places.empty(); ++k) {
    const std::size_t i = draft.random.next() % places.size();
    depth[places[i]] = glm::mix(kPocketFrom, draft.mm("deepest_mm"), k == 0 ? 1 : uniform(draft.random));
    places.erase(places.begin() + static_cast<std::ptrdiff_t>(i));
  }
  draft.gum.emplace(tooth);
  for (std::size_t i = 0; i < kSites; ++i) {
    const double along = 0.36 * tooth.form.neck.x * (1 - static_cast<double>(i % 3));
    if (i % 3 == 1 && tooth.furcation > 0) depth[i] = std::min(depth[i], tooth.furcation - kAboveFurcation);
    draft.gum->add_pocket(along, i < 3 ? 1 : -1, depth[i], 0.5 * draft.mm("pocket_width_mm"));
    const Pocket& pocket = draft.gum->pockets.back();
    draft.explore["sites"].push_back({{"name", Ordered::parse(names[i].text())},
                                      {"margin_mm", draft.point(pocket.margin)},
                                      {"floor_mm", draft.point(pocket.floor)}});
  }
}

/// The socket of a hip: a cup of 56 mm, its axis tilted from the socket's own.
void socket(Draft& draft) {
  const double tilt = glm::radians(draft.out.parameters.at("tilt_deg"));
  const double around = 2 * std::numbers::pi * uniform(draft.random);
  draft.approach_along({std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt)});
  const dvec3 deep = glm::transpose(draft.R) * dvec3(0, 0, -draft.mm("deepen_mm"));
  draft.ideal["remove"].push_back(
      {{"capsule",
        {{"a_mm", draft.point(deep)}, {"b_mm", draft.point(deep + dvec3(0, 0, 40e-3))}, {"radius_mm", 28}}}});
}

/// An implant in bone of a class of Lekholm and Zarb. The shipped plan's axis is tilted to mesial or distal.
void implant(Draft& draft) {
  auto& have = draft.out.parameters;
  const auto bone = static_cast<std::size_t>(std::lround(have.at("bone_class")));
  have["bone_class"] = static_cast<double>(bone);
  constexpr std::array kClasses = {"", "I", "II", "III", "IV"};
  draft.base["tissue"]["bone"]["class"] = kClasses.at(bone);
  draft.base["tissue"]["bone"]["seed"] = draft.random.next() % 1000;
  Ordered& axis = draft.base["implant"]["plan"]["axis"];
  const double tilt = glm::radians(have.at("tilt_deg")) * (uniform(draft.random) < 0.5 ? -1 : 1);
  const glm::dvec3 planned = glm::normalize(glm::dvec3(axis[0], axis[1], axis[2]));
  const glm::dvec3 tilted = std::cos(tilt) * planned + std::sin(tilt) * glm::dvec3(1, 0, 0);
  axis = {tilted.x, tilted.y, tilted.z};
  draft.approach_along(-tilted);
  draft.ideal = nullptr;
}

using Recipe = void (*)(Draft&);
const std::map<std::string, Recipe> kRecipes = {{"fissure", fissure},   {"lesion", lesion},
                                                {"access", access},     {"lingual_access", lingual_access},
                                                {"boxes", boxes},       {"onlay", onlay},
                                                {"crown", crown},       {"lingual_box", lingual_box},
                                                {"cervical", cervical}, {"fracture", fracture},
                                                {"calculus", calculus}, {"pockets", pockets},
                                                {"implant", implant},   {"hidden_caries", hidden_caries},
                                                {"socket", socket}};

}  // namespace

void apply_recipe(Draft& draft) {
  kRecipes.at(draft.family["recipe"].string())(draft);
  if (draft.family.boolean_or("prepared", false)) {
    draft.prepare = draft.ideal["remove"];
    draft.ideal = {{"unprepared", true}};
  }
}

}  // namespace typodont
