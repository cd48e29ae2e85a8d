#include "engine/app/cases/case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/hands/expert.h"
#include "engine/app/hands/task_student.h"
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
constexpr dvec3 kTop{6.9e-3, 5.5e-3, 20.0e-3};  // m, frame W: position of the shipped exercises' cusps
constexpr double kExpertPoints = 95, kCarelessPoints = 60;
constexpr dvec3 kSlip{0.45e-3, 0.45e-3, -0.5e-3};  // m, displacement of the careless hand from the plan

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

/// The types of tooth of a case family.
std::vector<std::string> teeth_of(const Json& family) {
  std::vector<std::string> teeth;
  for (const Json& tooth : family["teeth"].items()) teeth.push_back(tooth.string());
  return teeth;
}

/// A carious lesion along the line a–b (x, y), from the fissure down: narrow in the enamel, widest at the border of
/// enamel and dentin, round in the dentin.
struct Lesion {
  glm::dvec2 a{0}, b{0};
  double top = 0, border = 0, depth = 0;  // m; top: the surface's z; border, depth: below the top
  double opening = 0, width = 0;          // m, radii at the surface and at the enamel-dentin border
  /// Hardness at p, as a fraction of the hardness of sound tissue. 0: p is outside the lesion.
  double hardness(const dvec3& p) const {
    const glm::dvec2 q(p), along = b - a;
    const double length2 = glm::dot(along, along);
    const double t = length2 > 0 ? std::clamp(glm::dot(q - a, along) / length2, 0.0, 1.0) : 0;
    const double beside = glm::length(q - a - t * along), down = top - p.z;
    if (down > depth) return 0;
    if (down < border) return beside < glm::mix(opening, width, std::max(down, 0.0) / border) ? 0.3 : 0;
    const double s = (down - border) / (depth - border);
    // Softest at the border (Knoop hardness by ICDAS code: Shimizu, Dent Mater J 34 (2015) 252).
    return beside < width * std::sqrt(1 - s * s) ? 0.15 + 0.45 * s : 0;
  }
};

/// A recipe's input and output. Points: tooth's frame, m.
struct Draft {
  Case& out;
  dvec3 offset;  // m, from the tooth's frame to frame W
  Ordered ideal;
  std::optional<Lesion> lesion;

  double mm(const char* name) const { return out.parameters.at(name) * kMillimetre; }
  Ordered point(const dvec3& p) const {
    const dvec3 q = p + offset;
    return {in_mm(q.x), in_mm(q.y), in_mm(q.z)};
  }
  double above() const { return out.tooth.crown + 3e-3; }
  Ordered halfspace(const dvec3& normal, const dvec3& on) const {
    return {{"halfspace",
             {{"normal", {normal.x, normal.y, normal.z}}, {"offset_mm", in_mm(glm::dot(normal, on + offset))}}}};
  }
  Ordered shaft(const glm::dvec2& at, double floor, double radius) const {
    const double height = above() - floor;
    return {{"cylinder",
             {{"center_mm", point({at.x, at.y, floor + 0.5 * height})},
              {"axis", {0, 0, 1}},
              {"radius_mm", radius / kMillimetre},
              {"height_mm", height / kMillimetre}}}};
  }
  /// Adds to the ideal an upright slot with round ends, as wide as a round bur that can cut it.
  void slot(const glm::dvec2& a, const glm::dvec2& b, double floor, double width) {
    const glm::dvec2 u = glm::normalize(b - a);
    const dvec3 along(u, 0), across(-u.y, u.x, 0), low(a, floor), high(b, above());
    ideal["remove"].push_back(
        {{"intersection",
          {halfspace(along, high), halfspace(-along, low), halfspace(across, low + 0.5 * width * across),
           halfspace(-across, low - 0.5 * width * across), halfspace({0, 0, 1}, high), halfspace({0, 0, -1}, low)}}});
    for (const glm::dvec2& end : {a, b}) ideal["remove"].push_back(shaft(end, floor, 0.5 * width));
  }
  /// Depth of the enamel-dentin border below `top`, m.
  double enamel_depth(const glm::dvec2& at, double top) const {
    double down = 0;
    while (down < 3e-3 && out.tooth.tissue({at.x, at.y, top - down - 1e-5}) == Tissue::kEnamel) down += 0.05e-3;
    return down;
  }
};

/// Half the length of the outline, m. 1.8 mm of the marginal ridges remain (rubric rcampus PX4C443: 1.5 to 2 mm).
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
  double deepest = lesion.border;  // m below the top: largest depth that leaves the stated distance to the pulp
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
  // The slot must fit between the walls of the pulp chamber at half its height.
  const double z = 0.5 * (tooth.chamber_roof + tooth.chamber_floor);
  const auto half = [&](const dvec3& along) {
    double reach = 0;
    while (reach < 4e-3 && tooth.pulp_distance(dvec3(0, 0, z) + reach * along) < 0) reach += 0.02e-3;
    return reach;
  };
  const double x = half({1, 0, 0}), y = half({0, 1, 0});
  const double width = 2 * std::min(x, y), reach = std::max(x, y) - 0.5 * width;
  if (width < 1.3e-3 || reach < 0.05e-3)
    throw RunFailure(
        fmt::format("the pulp chamber is {:.2f} mm wide, too narrow for the bur of 1.2 mm", width / kMillimetre));
  const glm::dvec2 end = x > y ? glm::dvec2(reach, 0) : glm::dvec2(0, reach);
  draft.slot(-end, end, z, width);
}

using Recipe = void (*)(Draft&);
const std::map<std::string, Recipe> kRecipes = {{"fissure", fissure}, {"lesion", lesion}, {"access", access}};

void apply_lesion(Draft& draft) {
  haptics::DenseTissue& tissue = draft.out.tissue;
  tissue.hardness.assign(tissue.tissue.size(), haptics::kOwnHardness);
  for (int x = 0; x < tissue.size.x; ++x)
    for (int y = 0; y < tissue.size.y; ++y)
      for (int z = 0; z < tissue.size.z; ++z) {
        const std::size_t i = tissue.at(x, y, z);
        if (tissue.tissue[i] != Tissue::kEnamel && tissue.tissue[i] != Tissue::kDentin) continue;
        const double hardness = draft.lesion->hardness(tissue.frame.to_world(dvec3(x, y, z)));
        if (hardness == 0) continue;
        tissue.tissue[i] = Tissue::kCaries;
        tissue.hardness[i] = haptics::hardness_byte(hardness);
      }
}

/// Number of connected pieces of the tissue `which`, connected by voxel faces. kAir: of all tissue.
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
    // Air surrounds the tooth: every neighbour has a valid index.
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

/// Throws RunFailure if the tooth or the lesion has several pieces, or if too little tissue covers the pulp.
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

/// Cuts the strokes of a plan without a servo. Each stroke is displaced by `slip` (m).
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

/// Checks the exercise: the exact plan must reach the ideal with the scene's tools; the same plan by a careless hand
/// must fail.
void grade(Case& result, const fs::path& out, const haptics::TissueVolume& start) {
  const Json text = Json::parse(result.scene, out.string());
  const Scene scene = parse_scene(text, out);
  const TaskEvaluator judge(scene, start);
  const auto points = [&](const haptics::TissueVolume& after) {
    session::ScoreInput input;
    input.before = start.volumes();
    input.after = after.volumes();
    (void)judge.judge(after, input);
    return session::score_of_scene(text, input).points;
  };
  Expert expert(scene, start);
  haptics::TissueVolume exact = start.clone(), careless = start.clone();
  const std::vector<ExpertLeg> legs = expert.plan(start);
  carve(exact, scene, legs, dvec3(0));
  carve(careless, scene, legs, kSlip);
  result.expert = points(exact);
  result.careless = points(careless);
  const auto refuse = [&](const char* who, double reached, const char* expected, double limit) {
    throw RunFailure(fmt::format("{} reaches {:.1f} points, expected {} {:g}", who, reached, expected, limit));
  };
  if (result.expert < kExpertPoints) refuse("the exact plan", result.expert, "at least", kExpertPoints);
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
  Ordered task = base["task"];
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
  task.erase("protect");
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
    CaseFamily family{name, Json::load(find_scene(table[name]["base"].string()))["task"]["title"]["en"].string(),
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
  Draft draft{result, kTop - dvec3(0, 0, result.tooth.crown), Ordered::object()};
  kRecipes.at((*family)["recipe"].string())(draft);
  if (draft.lesion) apply_lesion(draft);
  check_tissue(draft);
  result.tissue.frame.origin += draft.offset;

  result.scene = scene_of(draft, *family, request, volume_file.file().filename().string()).dump(2) + "\n";
  const haptics::TissueVolume start(result.tissue);
  grade(result, out, start);
  start.save(volume_file.path());
  write_file_atomically(scene_file.path(), result.scene, FileKind::kJson);
  volume_file.keep();
  scene_file.keep();
  return result;
}

}  // namespace typodont
