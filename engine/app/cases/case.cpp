#include "engine/app/cases/case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/app/assets.h"
#include "engine/app/hands/expert.h"
#include "engine/app/hands/stroke_planner.h"
#include "engine/app/planning/volume_beside.h"
#include "engine/app/task/task.h"
#include "engine/base/error.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

using Ordered = nlohmann::ordered_json;

constexpr double kVoxel = 0.125e-3;             // m, edge of a voxel
constexpr dvec3 kTop{6.9e-3, 5.5e-3, 20.0e-3};  // m, frame W: point at the cusps' tops, as in the shipped exercises
constexpr double kExpertPoints = 95, kCarelessPoints = 60;
constexpr double kCorner = 0.65e-3;    // m, radius of the corners of a box-shaped cavity
constexpr double kBelowRoof = 1e-3;    // m, depth of a narrow access below the chamber's roof
constexpr double kNarrowest = 1.3e-3;  // m; a cavity is never narrower than this, so that a bur of 1.2 mm can cut it
// m, displacement of the strokes of a simulated careless hand from the planned strokes
constexpr dvec3 kSlip{0.55e-3, 0.55e-3, -0.5e-3};

Json families_table() {
  return Json::load(assets_folder() / "cases" / "families.json")["families"];
}

std::string pretty(double value) {
  return fmt::format("{:.2g}", value);
}

/// Converts m to mm, rounded to 0.1 µm.
double in_mm(double metres) {
  return std::round(metres / kMillimetre * 1e4) * 1e-4;
}

/// The types of tooth that a case family lists.
std::vector<std::string> teeth_of(const Json& family) {
  std::vector<std::string> teeth;
  for (const Json& tooth : family["teeth"].items()) teeth.push_back(tooth.string());
  return teeth;
}

/// A carious lesion along the line a–b (u, v), from the fissure down: narrow in the enamel, widest at the border of
/// enamel and dentin, round in the dentin.
struct Lesion {
  glm::dvec2 a{0}, b{0};
  double top = 0, border = 0, depth = 0;  // m: surface's height w; depths of dentin and of lesion's end below it
  double opening = 0, width = 0;          // m, radii at the surface and at the enamel-dentin border
  /// Hardness at p (u, v, w), as a fraction of the hardness of sound tissue. 0: p is outside the lesion.
  double hardness(const dvec3& p) const {
    const glm::dvec2 q(p), along = b - a;
    const double length2 = glm::dot(along, along);
    const double t = length2 > 0 ? std::clamp(glm::dot(q - a, along) / length2, 0.0, 1.0) : 0;
    const double beside = glm::length(q - a - t * along), down = top - p.z;
    if (down > depth) return 0;
    if (down < border) return beside < glm::mix(opening, width, std::max(down, 0.0) / border) ? 0.3 : 0;
    const double s = (down - border) / (depth - border);
    // Caries: softest at the enamel-dentin border (Knoop hardness by ICDAS code: Shimizu, Dent Mater J 34 (2015) 252).
    return beside < width * std::sqrt(1 - s * s) ? 0.15 + 0.45 * s : 0;
  }
};

/// The generated case and its geometry. Points are in the axes u, v, w, m: w out of the cavity's opening, u mesial.
struct Draft {
  Case& out;
  const Json& family;
  dvec3 offset;  // m, displacement from the tooth's frame to frame W
  Ordered ideal = Ordered::object(), neighbours = Ordered::array();
  std::optional<Lesion> lesion;
  glm::dmat3 R{1};     // columns: the axes u, v, w in the tooth's frame
  glm::dmat3 turn{1};  // rotation of the tooth in frame W

  double mm(const char* name) const { return out.parameters.at(name) * kMillimetre; }
  /// Turns the tooth by 180° about its axis, so that its buccal side faces the trainee.
  void show_buccal_side() { turn = {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}; }
  bool turned() const { return turn[0].x < 0; }
  void approach_along(const dvec3& w) { R = {{1, 0, 0}, glm::cross(w, dvec3(1, 0, 0)), w}; }
  Ordered direction(const dvec3& d) const {
    const dvec3 to = turn * R * d;
    return {to.x, to.y, to.z};
  }
  dvec3 to_W(const dvec3& p) const { return turn * R * p + offset; }
  Ordered point(const dvec3& p) const {
    const dvec3 q = to_W(p);
    return {in_mm(q.x), in_mm(q.y), in_mm(q.z)};
  }
  double above() const { return out.tooth.crown + 3e-3; }
  Ordered halfspace(const dvec3& normal, const dvec3& on) const {
    return {
        {"halfspace", {{"normal", direction(normal)}, {"offset_mm", in_mm(glm::dot(turn * R * normal, to_W(on)))}}}};
  }
  Ordered shaft(const glm::dvec2& at, double floor, double radius) const {
    const double height = above() - floor;
    return {{"cylinder",
             {{"center_mm", point({at.x, at.y, floor + 0.5 * height})},
              {"axis", direction({0, 0, 1})},
              {"radius_mm", radius / kMillimetre},
              {"height_mm", height / kMillimetre}}}};
  }
  /// An upright block along the line from a to b, with the width `width`, from the height `floor` to above the tooth.
  Ordered block(const glm::dvec2& a, const glm::dvec2& b, double floor, double width) const {
    const glm::dvec2 t = glm::normalize(b - a);
    const dvec3 along(t, 0), across(-t.y, t.x, 0), low(a, floor), high(b, above());
    return {{"intersection",
             {halfspace(along, high), halfspace(-along, low), halfspace(across, low + 0.5 * width * across),
              halfspace(-across, low - 0.5 * width * across), halfspace({0, 0, 1}, high), halfspace({0, 0, -1}, low)}}};
  }
  /// Adds an upright slot with round ends to the target shape. A round bur of the slot's width can cut it.
  void slot(const glm::dvec2& a, const glm::dvec2& b, double floor, double width) {
    ideal["remove"].push_back(block(a, b, floor, width));
    for (const glm::dvec2& end : {a, b}) ideal["remove"].push_back(shaft(end, floor, 0.5 * width));
  }
  /// Adds a box-shaped cavity, open towards the neighbouring tooth (side 1: mesial, -1: distal), with round corners at
  /// u = `axial`.
  void box(double side, double axial, double middle, double width, double floor) {
    const double end = side * (0.5 * out.tooth.md + 1e-3), inner = axial + side * kCorner;
    ideal["remove"].push_back(block({inner, middle}, {end, middle}, floor, width));
    ideal["remove"].push_back(block({axial, middle}, {end, middle}, floor, width - 2 * kCorner));
    for (const double edge : {-1.0, 1.0})
      ideal["remove"].push_back(shaft({inner, middle + edge * (0.5 * width - kCorner)}, floor, kCorner));
  }
  /// Adds a neighbouring tooth: the tooth itself, mirrored at its contact point.
  void add_neighbour(double side) {
    const CaseTooth& tooth = out.tooth;
    const dvec3 contact(side * 0.5 * tooth.md, -tooth.form.lean * tooth.form.proximal, tooth.form.proximal);
    neighbours.push_back({{"contact_mm", point(glm::transpose(R) * contact)}});
  }
  /// Height w of the tooth's surface at (u, v), m.
  double surface(const glm::dvec2& at) const {
    double w = above();
    while (w > 0 && out.tooth.distance(R * dvec3(at, w)) > 0) w -= 0.02e-3;
    return w;
  }
  /// Depth of the enamel-dentin border below `top`, m.
  double enamel_depth(const glm::dvec2& at, double top) const {
    double down = 0;
    while (down < 3e-3 && out.tooth.tissue(R * dvec3(at, top - down - 1e-5)) == Tissue::kEnamel) down += 0.05e-3;
    return down;
  }
};

/// Half the length of the cavity's outline, m. 1.8 mm of the marginal ridges remain (rubric rcampus PX4C443: 1.5 to 2
/// mm).
double half_outline(const CaseTooth& tooth) {
  return std::min(0.5 * tooth.md - 1.8e-3, 0.24 * tooth.md + 0.2e-3);
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
  draft.slot(a, b, surface - draft.mm("depth_mm"), width);
  draft.out.parameters["length_mm"] = (2 * reach + width) / kMillimetre;
  const glm::dvec2 middle = 0.5 * (a + b);
  Lesion lesion{glm::mix(middle, a, 0.6), glm::mix(middle, b, 0.6), tooth.surface(middle.x, tooth.fissure(middle.x))};
  lesion.depth = std::min(draft.mm("lesion_depth_mm"), lesion.top - (surface - draft.mm("depth_mm")) - 0.15e-3);
  lesion.border = 0.7 * lesion.depth;
  lesion.opening = 0.12e-3;
  lesion.width = 0.3 * width;
  draft.lesion = lesion;
}

void lesion(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const glm::dvec2 at(0, tooth.fissure(0));
  Lesion lesion{at, at, tooth.surface(at.x, at.y)};
  lesion.border = draft.enamel_depth(at, lesion.top) + 0.1e-3;
  double deepest = lesion.border;  // m below the top, limit of the lesion's depth; grows until the pulp is too near
  while (deepest < 8e-3 && tooth.pulp_distance({at.x, at.y, lesion.top - deepest}) > draft.mm("pulp_left_mm"))
    deepest += 0.02e-3;
  lesion.depth = std::min(draft.mm("lesion_depth_mm"), deepest);
  if (lesion.depth < lesion.border + 0.5e-3)
    throw RunFailure(fmt::format("only {:.2f} mm of dentin for a lesion that ends {:.2f} mm from the pulp",
                                 (deepest - lesion.border) / kMillimetre, draft.mm("pulp_left_mm") / kMillimetre));
  draft.out.parameters["lesion_depth_mm"] = lesion.depth / kMillimetre;
  draft.out.parameters["pulp_left_mm"] = tooth.pulp_distance({at.x, at.y, lesion.top - lesion.depth}) / kMillimetre;
  lesion.opening = 0.3e-3;
  lesion.width = 0.5 * draft.mm("lesion_width_mm");
  draft.lesion = lesion;
  draft.ideal = {{"remove_tissue", {"caries"}}, {"grow_mm", 0.12}};
  draft.ideal["remove"].push_back(draft.shaft(at, lesion.top - lesion.border, lesion.width));
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
  const double x = half({1, 0, 0}), y = half({0, 1, 0}), min = molar ? 0 : kNarrowest;
  const double width = std::max(2 * std::min(x, y), min);
  const double reach = std::max(std::max(x, y) - 0.5 * width, molar ? 0 : 0.3e-3);
  if (width < kNarrowest || reach < 0.05e-3)
    throw RunFailure(
        fmt::format("the pulp chamber is {:.2f} mm wide, too narrow for the bur of 1.2 mm", width / kMillimetre));
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

/// Adds the cavity: a slot along the fissure, and a box towards each neighbouring tooth.
void boxes(Draft& draft) {
  const CaseTooth& tooth = draft.out.tooth;
  const double width = draft.mm("isthmus_mm"), reach = half_outline(tooth) - 0.5 * width;
  const double floor = tooth.surface(0, tooth.fissure(0)) - draft.mm("depth_mm");
  const double gingival = tooth.form.proximal - draft.mm("clearance_mm");
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
    end.x = axial + side * kCorner;  // the slot ends inside the box
    draft.add_neighbour(side);
  }
  draft.slot(ends[0], ends[1], floor, width);
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

/// Adds a slot in the buccal surface above the neck. In its middle, the slot has the depth "depth_mm".
void cervical(Draft& draft) {
  draft.approach_along({0, 1, 0});  // axis v points towards the root
  draft.show_buccal_side();
  const double width = draft.mm("height_mm"), reach = 0.5 * (draft.mm("length_mm") - width);
  const double v = -draft.mm("above_neck_mm") - 0.5 * width;
  const double top = draft.surface({0, v}), floor = top - draft.mm("depth_mm");
  draft.slot({-reach, v}, {reach, v}, floor, width);
  Lesion lesion{{-0.5 * reach, v}, {0.5 * reach, v}, top};
  lesion.depth = draft.mm("depth_mm") - 0.15e-3;
  lesion.border = 0.6 * lesion.depth;
  lesion.opening = 0.25 * width;
  lesion.width = 0.4 * width;
  draft.lesion = lesion;
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

using Recipe = void (*)(Draft&);
const std::map<std::string, Recipe> kRecipes = {
    {"fissure", fissure}, {"lesion", lesion}, {"access", access},           {"lingual_access", lingual_access},
    {"boxes", boxes},     {"crown", crown},   {"lingual_box", lingual_box}, {"cervical", cervical}};

void apply_lesion(Draft& draft) {
  haptics::DenseTissue& tissue = draft.out.tissue;
  const glm::dmat3 to_bur = glm::transpose(draft.R);
  tissue.hardness.assign(tissue.tissue.size(), haptics::kOwnHardness);
  for (int x = 0; x < tissue.size.x; ++x)
    for (int y = 0; y < tissue.size.y; ++y)
      for (int z = 0; z < tissue.size.z; ++z) {
        const std::size_t i = tissue.at(x, y, z);
        if (tissue.tissue[i] != Tissue::kEnamel && tissue.tissue[i] != Tissue::kDentin) continue;
        const double hardness = draft.lesion->hardness(to_bur * tissue.frame.to_world(dvec3(x, y, z)));
        if (hardness == 0) continue;
        tissue.tissue[i] = Tissue::kCaries;
        tissue.hardness[i] = haptics::hardness_byte(hardness);
      }
}

/// Rotates the tissue by 180° about z.
void turn_round(haptics::DenseTissue& tissue) {
  const auto reverse_columns = [&](auto& values) {
    if (values.empty()) return;
    const auto height = static_cast<std::ptrdiff_t>(tissue.size.z);
    std::ranges::reverse(values);
    for (auto column = values.begin(); column != values.end(); column += height) std::reverse(column, column + height);
  };
  reverse_columns(tissue.distance), reverse_columns(tissue.tissue), reverse_columns(tissue.hardness);
  const dvec3 far = tissue.frame.to_world(dvec3(tissue.size - 1));
  tissue.frame.origin.x = -far.x, tissue.frame.origin.y = -far.y;
}

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

/// Throws RunFailure if the tooth or the lesion consists of several pieces, or if too little tissue covers the pulp.
void check_tissue(const Draft& draft) {
  const haptics::DenseTissue& tissue = draft.out.tissue;
  if (const int n = pieces(tissue, Tissue::kAir); n != 1) throw RunFailure(fmt::format("the tooth has {} pieces", n));
  double cover = 1;
  for (std::size_t i = 0; i < tissue.tissue.size(); ++i)
    if (tissue.tissue[i] == Tissue::kPulp && tissue.distance[i] > -tissue.band)
      cover = std::min(cover, -static_cast<double>(tissue.distance[i]));
  if (cover < 0.2e-3) throw RunFailure(fmt::format("only {:.2f} mm of tissue around the pulp", cover / kMillimetre));
  if (!draft.lesion) return;
  if (const int n = pieces(tissue, Tissue::kCaries); n != 1)
    throw RunFailure(fmt::format("the lesion has {} pieces", n));
}

/// Cuts the strokes of a plan directly, without a servo. Each stroke is displaced by `slip` (m).
void carve(haptics::TissueVolume& volume, const Scene& scene, const std::vector<ExpertLeg>& legs, const dvec3& slip) {
  const auto tools = haptics::tool_set(scene.servo);
  std::size_t tool = 0;
  std::optional<Pose> last;
  for (const ExpertLeg& leg : legs) {
    if (leg.kind == ExpertLeg::Kind::kTake) tool = leg.tool;
    if (leg.kind == ExpertLeg::Kind::kWait || leg.kind == ExpertLeg::Kind::kTake) continue;
    if (leg.kind == ExpertLeg::Kind::kCut && last)
      carve_strokes(volume, tools[tool], {{{last->p + slip, last->R}, {leg.to.p + slip, leg.to.R}}});
    last = leg.to;
  }
}

/// Checks the exercise: the exact plan must reach the ideal shape with the scene's tools; the same plan by a careless
/// hand must fail.
void grade(Case& result, Ordered scene_text, const fs::path& volume, const glm::dmat3& R, const fs::path& out,
           const haptics::TissueVolume& start) {
  // The neighbouring teeth are read from the volume's file, which has a temporary name here.
  if (scene_text.contains("surroundings")) scene_text["tissue"]["volume"] = fs::absolute(volume).string();
  const Json text = Json::parse(scene_text.dump(), out.string());
  const Scene scene = parse_scene(text, out);
  const TaskEvaluator judge(scene, start);
  const auto score = [&](const haptics::TissueVolume& after) {
    session::ScoreInput input;
    input.before = start.volumes();
    input.after = after.volumes();
    (void)judge.judge(after, input);
    return session::score_of_scene(text, input);
  };
  Expert expert(scene, start);
  haptics::TissueVolume exact = start.clone(), careless = start.clone();
  const std::vector<ExpertLeg> legs = expert.plan(start);
  carve(exact, scene, legs, dvec3(0));
  carve(careless, scene, legs, R * kSlip);
  const session::Score reached = score(exact);
  result.expert = reached.points;
  result.careless = score(careless).points;
  const auto refuse = [&](const std::string& who, double total, const char* expected, double limit) {
    throw RunFailure(fmt::format("{} reaches {:.1f} points, expected {} {:g}", who, total, expected, limit));
  };
  if (result.expert < kExpertPoints) {
    const auto& worst = *std::ranges::max_element(reached.items, {}, [](const auto& i) { return i.full - i.points; });
    refuse(fmt::format("the exact plan (which loses {:.1f} by {})", worst.full - worst.points, worst.name),
           result.expert, "at least", kExpertPoints);
  }
  if (result.careless > kCarelessPoints) refuse("a careless hand", result.careless, "at most", kCarelessPoints);
}

Ordered scene_of(Draft& draft, const Json& family, const CaseRequest& request, const std::string& volume) {
  const Ordered base = Ordered::parse(Json::load(find_scene(family["base"].string())).text());
  Ordered scene = {{"name", fmt::format("{}-{}", request.family, request.seed)},
                   {"description", fmt::format("Case {} of the family {}, difficulty {:g}: {} ({}), {:.0f} years.",
                                               request.seed, request.family, request.difficulty, draft.out.tooth.name,
                                               draft.out.tooth.type, draft.out.tooth.age)},
                   {"tissue", {{"volume", volume}}}};
  for (const char* key : {"tools", "spindle", "spray", "tooth", "parts"})
    if (base.contains(key)) scene[key] = base[key];
  if (!draft.neighbours.empty()) scene["surroundings"] = {{"neighbours", draft.neighbours}};
  Ordered task = base["task"];
  for (const char* key : {"title", "steps"})
    if (const auto own = family.find(key)) task[key] = Ordered::parse(own->text());
  for (const std::string& language : family["goal"].keys()) {
    std::string filled = family["goal"][language].string();
    const auto fill = [&](const std::string& name, const std::string& value) {
      const std::string mark = "{" + name + "}";
      if (const auto at = filled.find(mark); at != std::string::npos) filled.replace(at, mark.size(), value);
    };
    fill("tooth", draft.out.tooth.type);
    for (const auto& [name, value] : draft.out.parameters) fill(name, pretty(value));
    task["goal"][language] = filled;
  }
  task["ideal"] = draft.ideal;
  task["axis"] = draft.direction({0, 0, 1});
  task.erase("protect");
  if (const auto without = family.find("without"))
    for (const Json& name : without->items())
      std::erase_if(task["rules"].get_ref<Ordered::array_t&>(),
                    [&](const Ordered& own) { return own["name"] == name.string(); });
  if (const auto rules = family.find("rules"))
    for (const Json& rule : rules->items())
      for (Ordered& own : task["rules"])
        if (own["name"] == rule["name"].string()) own = Ordered::parse(rule.text());
  scene["task"] = task;
  return scene;
}

}  // namespace

std::vector<CaseFamily> case_families() {
  std::vector<CaseFamily> families;
  const Json table = families_table();
  for (const std::string& name : table.keys()) {
    const auto title = table[name].find("title");
    CaseFamily family{
        name, (title ? *title : Json::load(find_scene(table[name]["base"].string()))["task"]["title"])["en"].string(),
        teeth_of(table[name]), table[name]["parameters"].keys()};
    families.push_back(std::move(family));
  }
  return families;
}

Case make_case(const CaseRequest& request, const fs::path& out) {
  const Json table = families_table();
  const auto family = table.find(request.family);
  if (!family)
    throw Error("case", "", request.family, fmt::format("one of the families {}", fmt::join(table.keys(), ", ")));
  const std::vector<std::string> teeth = teeth_of(*family);
  SplitMix64 random{request.seed};
  std::string tooth = teeth[random.next() % teeth.size()];
  if (!request.tooth.empty()) {
    if (std::ranges::find(teeth, request.tooth) == teeth.end())
      throw Error("--tooth", "", request.tooth, fmt::format("one of {}", fmt::join(teeth, ", ")));
    tooth = request.tooth;
  }
  require_volume_beside(out, Over::kNoInput);
  PartialFile volume_file(volume_beside(out), FileKind::kVolume), scene_file(out, FileKind::kJson);
  Case result;
  const Json parameters = (*family)["parameters"];
  for (const std::string& name : parameters.keys()) {
    const std::vector<double> easy = parameters[name]["easy"].numbers(2), hard = parameters[name]["hard"].numbers(2);
    const double low = glm::mix(easy[0], hard[0], request.difficulty);
    const double high = glm::mix(easy[1], hard[1], request.difficulty);
    result.parameters[name] = std::round(glm::mix(low, high, uniform(random)) * 100) / 100;
  }
  result.tooth = make_tooth(tooth, result.parameters.at("age"), random);
  result.tissue = sample_tooth(result.tooth, kVoxel);
  Draft draft{result, *family, kTop - dvec3(0, 0, result.tooth.crown)};
  kRecipes.at((*family)["recipe"].string())(draft);
  if (draft.lesion) apply_lesion(draft);
  check_tissue(draft);
  if (draft.turned()) turn_round(result.tissue);
  result.tissue.frame.origin += draft.offset;

  const Ordered scene = scene_of(draft, *family, request, volume_file.file().filename().string());
  result.scene = scene.dump(2) + "\n";
  const haptics::TissueVolume start(result.tissue);
  start.save(volume_file.path());
  grade(result, scene, volume_file.path(), draft.turn * draft.R, out, start);
  write_file_atomically(scene_file.path(), result.scene, FileKind::kJson);
  volume_file.keep();
  scene_file.keep();
  return result;
}

}  // namespace typodont
