// A session in which the simulated hand of an expert works in a shipped scene, in simulated time.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "engine/app/assets.h"
#include "engine/app/hands/expert_hand.h"
#include "engine/app/hands/implant_expert.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/stepped.h"
#include "engine/app/task/damage.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/task.h"

namespace typodont::test {

struct ExpertResult {
  double percent = 0, seconds = 0;
  double decay_seen = 0;  // fraction of the cut surface that shows caries
  std::string items;      // the score's items, one per line
};

/// Returns the fraction of the samples next to new surface that are labelled as caries.
inline double decay_on_new_surface(const haptics::TissueVolume& before, const haptics::TissueVolume& after) {
  const DenseCopy now = dense_copy(after);
  const DenseCopy then =
      dense_copy(before, glm::ivec3(glm::round(before.frame().to_voxels(now.frame.origin))), now.field.size);
  double fresh = 0, decay = 0;
  for (std::size_t i = 0; i < now.tissue.size(); ++i) {
    if (now.field.distance[i] > 0 || now.field.distance[i] < -1 || then.field.distance[i] > -1.5f) continue;
    ++fresh;
    decay += now.tissue[i] == Tissue::kCaries;
  }
  return fresh > 0 ? decay / fresh : 0;
}

/// Runs the expert's hand with servo and carver, tick by tick, and scores the result like any session. Throws
/// RunFailure if the session lasts longer than `longest` seconds.
inline ExpertResult expert_session(const std::string& name, double longest) {
  const Scene scene = read_scene(assets_folder() / "scenes" / (name + ".json"));
  const haptics::TissueVolume start = load_untouched(scene);
  const TaskEvaluator judge(scene, start);
  SteppedSession session(scene, load_tissue(scene), 1000);
  session::HandMeter meter(1000);
  std::optional<DamageMeter> damage = damage_meter(scene);
  std::optional<HeatMeter> heat = heat_meter(scene, start);
  std::optional<session::ImplantMeter> surgery;
  std::unique_ptr<haptics::HapticDevice> hand;
  if (scene.implant) {
    surgery.emplace(*scene.implant);
    hand = std::make_unique<ImplantExpert>(scene, 1000);
  } else {
    hand = std::make_unique<PlanningExpert>(scene, session.carver(), 1000);
  }
  while (session.advance(*hand)) {
    const ServoTick& tick = session.last();
    if (to_seconds(tick.t) > longest) throw RunFailure(name + ": the expert does not end");
    meter.add({&tick, 1});
    if (damage) damage->add({&tick, 1});
    if (heat) heat->add({&tick, 1}, scene.spray_on);
    if (surgery) surgery->add({&tick, 1});
  }
  session::ScoreInput input;
  input.before = start.volumes();
  input.after = session.carver().volume().volumes();
  input.hand = meter.result();
  if (damage) input.damage = damage->result();
  if (heat) input.heat = heat->result();
  if (surgery) {
    input.implant = surgery->result();
    measure_bed(*scene.implant, session.carver().volume(), *input.implant);
  }
  judge.judge(session.carver().volume(), input);
  const session::Score score = session::score(input, session::rules_of_scene(Json::parse(scene.text, "scene"), input));
  ExpertResult result{100 * score.points / score.full, input.hand.time,
                      decay_on_new_surface(start, session.carver().volume()), ""};
  for (const session::ScoreItem& item : score.items) {
    if (item.weight > 0)
      result.items += fmt::format("{} = {:.3f} {} (target {:.3f}): {:.1f} of {:.0f}\n", item.name, item.value,
                                  item.unit, item.target, item.points, item.weight);
  }
  fmt::print("{} by an expert's hand: {:.1f} % in {:.0f} s\n", name, result.percent, result.seconds);
  return result;
}

}  // namespace typodont::test
