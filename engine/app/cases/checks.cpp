#include "engine/app/cases/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

#include "engine/app/hands/expert.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/hands/probing_hand.h"
#include "engine/app/hands/stroke_planner.h"
#include "engine/app/stepped.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/in_parallel.h"
#include "engine/base/voxels.h"
#include "haptics/solid.h"

namespace typodont {

namespace {

constexpr double kExpertPoints = 95, kCarelessPoints = 60;
// m, displacement of the strokes of a simulated careless hand from the planned strokes, on a tooth
constexpr dvec3 kSlip{0.55e-3, 0.55e-3, -0.5e-3};
// A careless examiner: the same displacement, three times the force, the ball not held against the tooth.
constexpr ProbingHabit kCarelessProbing{.slip = dvec3(kSlip.x, kSlip.y, 0), .force = 0.6, .lean = 0};
constexpr int kMaxRounds = 200;  // limit of the layers of a filling

/// Cuts the strokes of a plan directly, without a servo, with the hand's errors. `R`: the cavity's axes in frame W.
void carve(haptics::TissueVolume& volume, const Scene& scene, const std::vector<ExpertLeg>& legs, const glm::dmat3& R,
           const HandErrors& hand) {
  const auto tools = haptics::tool_set(scene.servo);
  const dquat tilt = glm::angleAxis(hand.tilt.x, R[0]) * glm::angleAxis(hand.tilt.y, R[1]);
  SplitMix64 random{hand.seed};
  std::size_t tool = 0;
  std::optional<Pose> last;
  for (const ExpertLeg& leg : legs) {
    if (leg.kind == ExpertLeg::Kind::kTake) tool = leg.tool;
    if (leg.kind == ExpertLeg::Kind::kWait || leg.kind == ExpertLeg::Kind::kTake) continue;
    const dvec3 spread(normal(random), normal(random), normal(random));
    const Pose to{leg.to.p + R * (hand.shift + hand.spread * spread), tilt * leg.to.R};
    if ((leg.kind == ExpertLeg::Kind::kCut || leg.kind == ExpertLeg::Kind::kScrape) && last)
      carve_strokes(volume, tools[tool], {{*last, to}});
    last = to;
  }
}

struct FollowedPlan {
  haptics::TissueVolume exact;     // result of a filling; in other tasks, the start
  haptics::TissueVolume filled;    // before the first carving
  std::vector<ExpertLeg> carving;  // all cuts and carvings
};

/// Follows the expert's plans. Only a filling needs results of earlier plans for the next ones.
FollowedPlan follow_plans(Expert& expert, const Scene& scene, const glm::dmat3& R, const haptics::TissueVolume& start,
                          bool fills) {
  FollowedPlan followed{start.clone(), start.clone(), {}};
  for (int round = 0; round < (fills ? kMaxRounds : 1); ++round) {
    const std::vector<ExpertLeg> legs = expert.plan(followed.exact);
    if (legs.empty()) break;
    if (std::ranges::any_of(legs, [](const ExpertLeg& leg) { return leg.volume > 0; })) {
      followed.exact = expert.planned().clone();
      if (followed.carving.empty()) followed.filled = followed.exact.clone();
      continue;
    }
    if (fills) carve(followed.exact, scene, legs, R, {});
    followed.carving.insert(followed.carving.end(), legs.begin(), legs.end());
  }
  return followed;
}

constexpr double kRate = 500;  // Hz, of the servo

/// The score of a simulated surgeon or examiner.
session::Score perform(const Scene& scene, haptics::HapticDevice& hand, const haptics::TissueVolume& start) {
  SteppedSession session(scene, start.clone(), hand.info());
  session::HandMeter meter(kRate);
  std::optional<session::ImplantMeter> implant;
  if (scene.implant) implant.emplace(*scene.implant);
  FinishedHand finished;
  while (session.advance(hand)) {
    meter.add({&session.last(), 1});
    if (implant) implant->add({&session.last(), 1});
    if (scene.task->explore) finished.unexplored.push_back(session.last());
  }
  finished.input.hand = meter.result();
  if (implant) finished.input.implant = implant->result();
  return final_score(scene, session.carver().volume(), std::move(finished));
}

/// The scene with the implant's plan as a careless hand sees it: displaced, too deep and tilted.
Scene misread(const Scene& scene) {
  constexpr double kTimes = 3;  // displacement / that of a tooth's strokes
  constexpr double kTilt = 12;  // degrees
  Scene seen = scene;
  session::ImplantPlan& plan = seen.implant->plan;
  plan.entry_W += kTimes * (dvec3(kSlip.x, kSlip.y, 0) - kSlip.z * plan.axis_W);
  plan.axis_W = glm::angleAxis(glm::radians(kTilt), dvec3(0, 1, 0)) * plan.axis_W;
  return seen;
}

/// Feels the whole region, or its mesial half, and marks each lesion that it meets.
session::ExploreMeasures feel(const TaskEvaluator& judge, const Scene& scene, const haptics::TissueVolume& start,
                              bool half) {
  session::ExploreMeter meter = *judge.explore_meter();
  const DenseCopy copy = dense_copy(start);
  const auto region = haptics::read_solid_list(scene.task->region);
  dvec3 low, high;
  region.front()->bounds(low, high);
  const double border = half ? 0.5 * (low.x + high.x) : low.x;
  ServoTick tick{};
  for_each_voxel(copy.field.size, [&](int x, int y, int z) {
    const std::size_t i = copy.field.at(x, y, z);
    const dvec3 p = copy.frame.to_world(dvec3(x, y, z));
    if (std::abs(copy.field.distance[i]) > 0.5f || p.x < border || region.front()->distance(p) > 0) return;
    tick.X_WG.p = p;
    tick.depth = 1e-6;
    tick.pedal = copy.tissue[i] == Tissue::kCaries ? 1 : 0;
    meter.add({&tick, 1});
  });
  return meter.result();
}

}  // namespace

void grade(Case& result, const Json& text, const Scene& scene, const glm::dmat3& R, const haptics::TissueVolume& start,
           const std::vector<HandErrors>& hands) {
  if (!hands.empty() && (scene.task->explore || !scene.task->sites.empty() || scene.implant))
    throw Error("--hands", "", "a task without an ideal shape", "a family whose exact plan consists of strokes");
  session::Score reached;
  const auto perform_both = [&](auto& expert, auto& careless) {
    std::array<haptics::HapticDevice*, 2> both{&expert, &careless};
    std::array<session::Score, 2> scores;
    in_parallel(
        2, [&](std::size_t k) { scores[k] = perform(scene, *both[k], start); }, {}, /*block=*/1);
    reached = scores[0];
    result.careless = scores[1].points;
  };
  if (!scene.task->sites.empty()) {
    ProbingHand expert(scene, kRate), careless(scene, kRate, kCarelessProbing);
    perform_both(expert, careless);
  } else if (scene.task->explore) {
    const TaskEvaluator judge(scene, start);
    session::ScoreInput input;
    input.explore = feel(judge, scene, start, /*half=*/false);
    reached = session::score_of_scene(text, input);
    input.explore = feel(judge, scene, start, /*half=*/true);
    result.careless = session::score_of_scene(text, input).points;
  } else if (scene.implant) {
    ImplantExpert expert(scene, kRate), careless(misread(scene), kRate);
    perform_both(expert, careless);
  } else {
    Expert expert(scene, start, kExactMargins);
    const PerTissue before = start.volumes();
    const auto heat = heat_meter(scene, start);  // no stroke warms it
    const auto score = [&](const haptics::TissueVolume& after, const HandErrors& hand) {
      session::ScoreInput input;
      input.hand.force_mean = hand.force_mean;
      input.hand.force_max = hand.force_max;
      if (heat) input.heat = heat->result();
      input.before = before;
      input.after = after.volumes();
      (void)expert.judge().judge(after, input);
      return session::score_of_scene(text, input);
    };
    const auto tools = haptics::tool_set(scene.servo);
    const bool fills = std::ranges::any_of(tools, [](const auto& tool) { return tool.fill != Tissue::kAir; });
    const FollowedPlan followed = follow_plans(expert, scene, R, start, fills);
    // The exact hand, the careless one, then `hands`. A filling is placed as planned; only its carving has errors.
    std::vector<HandErrors> all{{}, {.shift = kSlip * expert.grip().size}};
    all.insert(all.end(), hands.begin(), hands.end());
    std::vector<session::Score> scores(all.size());
    in_parallel(
        all.size(),
        [&](std::size_t k) {
          haptics::TissueVolume after = (k == 0 ? followed.exact : followed.filled).clone();
          if (k > 0 || !fills) carve(after, scene, followed.carving, R, all[k]);
          scores[k] = score(after, all[k]);
        },
        {}, /*block=*/1);
    reached = scores[0];
    result.careless = scores[1].points;
    result.hands.assign(scores.begin() + 2, scores.end());
  }
  result.expert = reached.points;
  const auto refuse = [&](const std::string& who, double total, const char* expected, double limit) {
    throw RunFailure(fmt::format("{} reaches {:.1f} points, expected {} {:g}", who, total, expected, limit));
  };
  if (result.expert < kExpertPoints) {
    std::ranges::sort(reached.items, std::greater{}, [](const auto& i) { return i.full - i.points; });
    std::string losses;
    for (std::size_t i = 0; i < std::min<std::size_t>(reached.items.size(), 3); ++i)
      losses += fmt::format("{} {:.1f} by {}", i ? "," : "", reached.items[i].full - reached.items[i].points,
                            reached.items[i].name);
    refuse(fmt::format("the exact plan (which loses{})", losses), result.expert, "at least", kExpertPoints);
  }
  for (const session::ScoreItem& item : reached.items)
    if (item.critical)
      throw RunFailure(fmt::format("the exact plan makes a critical error: {} {:.3g}", item.name, item.value));
  if (result.careless > kCarelessPoints) refuse("a careless hand", result.careless, "at most", kCarelessPoints);
}

}  // namespace typodont
