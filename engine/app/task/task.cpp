#include "engine/app/task/task.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>

#include "engine/app/assets.h"
#include "engine/app/recording/recorded_tissue.h"
#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/scene/ideal.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/task/crown_ideal.h"
#include "engine/app/task/damage.h"
#include "engine/app/task/heat.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/report.h"
#include "haptics/import/import.h"
#include "haptics/import/mesh_solid.h"
#include "haptics/solid.h"

namespace typodont {

namespace {

// Margin around the region in which initial, final and target tissue differ, m.
constexpr double kRegionMargin = session::kPulpReach + 0.5e-3;
// Largest distance at which surfaces count as equal, voxels.
constexpr float kChanged = 0.02f;

/// Mesh files in the solids of a task are searched for only in the scene's folder.
const haptics::SolidFiles kTaskSolids{.find = {}, .read_mesh = haptics::read_mesh_solid};

/// Copies to `at` the distances of `other` at the same points, and the labels where `other` has them.
void sample_volume(const haptics::TissueVolume& other, DenseCopy& at) {
  const DenseCopy from = dense_copy(other);
  const double ratio = from.frame.voxel / at.frame.voxel;
  const glm::ivec3 n = at.field.size;
  for_each_voxel(n, [&](int x, int y, int z) {
    const dvec3 p = from.frame.to_voxels(at.frame.to_world(dvec3(x, y, z)));
    const std::size_t i = at.field.at(x, y, z);
    at.field.distance[i] = static_cast<float>(from.field.sample(p) * ratio);
    const glm::ivec3 near = glm::clamp(glm::ivec3(glm::round(p)), glm::ivec3(0), from.field.size - 1);
    const Tissue label = from.tissue[from.field.at(near.x, near.y, near.z)];
    if (label != Tissue::kAir) at.tissue[i] = label;
  });
}

/// Takes the inside of a closed mesh as the target shape. Tissue more than a voxel outside of it must be removed.
void take_mesh(const Ideal& ideal, const ScenePlace& place, DenseCopy& copy) {
  haptics::ImportOptions options;
  options.voxel = copy.frame.voxel;
  options.mesh_unit = ideal.mesh_unit;
  const haptics::TissueVolume mesh(haptics::import_tissue(find_file(*ideal.mesh, place), options).tissue);
  DenseCopy wanted = copy;
  sample_volume(mesh, wanted);
  for (std::size_t i = 0; i < copy.field.distance.size(); ++i) {
    const float d = wanted.field.distance[i];
    if (d > copy.field.distance[i] + 1) copy.field.distance[i] = d;
  }
}

void take_solids(const Ideal& ideal, DenseCopy& copy) {
  std::vector<float> labelled;
  if (!ideal.remove_tissue.empty()) labelled = label_distance(copy, ideal.remove_tissue).distance;
  const double h = copy.frame.voxel;
  const glm::ivec3 n = copy.field.size;
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t i = copy.field.at(x, y, z);
    const dvec3 p_W = copy.frame.to_world(dvec3(x, y, z));
    double gone = 1e9;
    for (const auto& solid : ideal.remove) gone = std::min(gone, solid->distance(p_W));
    if (!labelled.empty()) gone = std::min(gone, static_cast<double>(labelled[i]) * h);
    gone -= ideal.grow;
    for (const auto& solid : ideal.keep) gone = std::max(gone, -solid->distance(p_W));
    copy.field.distance[i] = std::max(copy.field.distance[i], static_cast<float>(-gone / h));
  });
}

session::Preparation cropped(const session::Preparation& in) {
  const glm::ivec3 n = in.before.size;
  glm::ivec3 lo(n), hi(-1);
  const auto differ = [](float a, float b) { return std::abs(a - b) > kChanged && std::min(a, b) < 1.5f; };
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t i = in.before.at(x, y, z);
    if (!differ(in.before.distance[i], in.after.distance[i]) &&
        (in.ideal.distance.empty() || !differ(in.before.distance[i], in.ideal.distance[i]))) {
      return;
    }
    lo = glm::min(lo, glm::ivec3(x, y, z));
    hi = glm::max(hi, glm::ivec3(x, y, z));
  });
  if (hi.x < 0) lo = hi = n / 2;
  const auto margin = static_cast<int>(std::ceil(kRegionMargin / in.frame.voxel));
  lo = glm::max(lo - margin, glm::ivec3(0));
  hi = glm::min(hi + margin, n - 1);

  session::Preparation out;
  out.frame = {in.frame.to_world(dvec3(lo)), in.frame.voxel};
  out.axis_W = in.axis_W;
  out.contour = in.contour;
  const glm::ivec3 size = hi - lo + 1;
  const auto cut = [&](const auto& values, auto& to) {
    if (values.empty()) return;
    to.reserve(voxel_count(size));
    for_each_voxel_between(lo, hi, [&](const glm::ivec3& i) { to.push_back(values[voxel_index(i, n)]); });
  };
  out.before.size = out.after.size = out.ideal.size = size;
  cut(in.before.distance, out.before.distance);
  cut(in.after.distance, out.after.distance);
  cut(in.ideal.distance, out.ideal.distance);
  cut(in.tissue, out.tissue);
  cut(in.keep, out.keep);
  return out;
}

/// For each sample: true if inside at least one solid.
std::vector<bool> inside(const std::vector<std::unique_ptr<haptics::Solid>>& solids, const DenseCopy& copy) {
  std::vector<bool> result;
  if (solids.empty()) return result;
  result.resize(copy.field.distance.size());
  const glm::ivec3 n = copy.field.size;
  for_each_voxel(n, [&](int x, int y, int z) {
    const dvec3 p_W = copy.frame.to_world(dvec3(x, y, z));
    result[copy.field.at(x, y, z)] =
        std::any_of(solids.begin(), solids.end(), [&](const auto& solid) { return solid->distance(p_W) <= 0; });
  });
  return result;
}

haptics::TissueVolume copy_of(const haptics::TissueVolume& volume) {
  return from_dense(dense_copy(volume), volume.band());
}

}  // namespace

std::optional<haptics::TissueVolume> ideal_tissue(const Scene& scene, const haptics::TissueVolume& start) {
  if (!scene.task || !scene.task->ideal) return std::nullopt;
  Ideal ideal;
  read_keys(*scene.task->ideal, [&](Keys& keys) { describe_ideal(keys, ideal, kTaskSolids); });
  DenseCopy copy = dense_copy(start);
  if (ideal.volume) {
    sample_volume(haptics::TissueVolume::load(find_file(*ideal.volume, scene.place)), copy);
  } else if (ideal.session) {
    // The ideal shape is the final tissue of a recorded session.
    const session::SessionReader session(find_file(*ideal.session, scene.place));
    sample_volume(tissue_at_end(session, scene_of(session, scene.place), copy_of(start)), copy);
  } else if (ideal.unprepared) {
    if (scene.prepare.empty()) scene.task->ideal->fail("\"unprepared\": true in a scene that prepares something");
    Scene whole = scene;
    whole.prepare.clear();
    const std::vector<float> prepared = copy.field.distance;
    sample_volume(load_tissue(whole), copy);
    const auto fills = std::ranges::find_if(haptics::tool_set(scene.servo),
                                            [](const haptics::Tool& tool) { return tool.fill != Tissue::kAir; });
    if (fills != haptics::tool_set(scene.servo).end())
      for (std::size_t i = 0; i < prepared.size(); ++i)
        if (prepared[i] > 0 && copy.field.distance[i] <= 0) copy.tissue[i] = fills->fill;
  } else if (ideal.mesh) {
    take_mesh(ideal, scene.place, copy);
  } else if (ideal.crown) {
    reduce_for_crown(*ideal.crown, glm::normalize(scene.task->axis_W), copy);
  } else {
    take_solids(ideal, copy);
  }
  haptics::TissueVolume made = from_dense(copy, start.band());
  made.set_natural_surface(start.natural_surface());
  return made;
}

haptics::TissueVolume finished_tissue(const Scene& scene, const haptics::TissueVolume& start) {
  if (std::optional<haptics::TissueVolume> ideal = ideal_tissue(scene, start)) return std::move(*ideal);
  DenseCopy copy = dense_copy(start);
  if (scene.implant) {
    const session::ImplantPlan& plan = scene.implant->plan;
    // The drilled hole is longer than the implant, so that its upper end is open.
    const session::ImplantCylinder bed{plan.apex_W(), plan.axis_W, 2 * plan.length, plan.bed_diameter / 2};
    const glm::ivec3 n = copy.field.size;
    for_each_voxel(n, [&](int x, int y, int z) {
      float& d = copy.field.distance[copy.field.at(x, y, z)];
      d = std::max(d, static_cast<float>(-bed.distance(copy.frame.to_world(dvec3(x, y, z))) / copy.frame.voxel));
    });
  }
  haptics::TissueVolume made = from_dense(copy, start.band());
  made.set_natural_surface(start.natural_surface());
  return made;
}

TaskEvaluator::TaskEvaluator(const Scene& scene, const haptics::TissueVolume& start)
    : start_(copy_of(start)), ideal_(ideal_tissue(scene, start)), task_(scene.task) {
  if (!task_) return;
  protect_ = haptics::read_solid_list(task_->protect, kTaskSolids);
  region_ = haptics::read_solid_list(task_->region, kTaskSolids);
  tip_ = haptics::tool_set(scene.servo).front().radius();
}

session::Preparation TaskEvaluator::preparation(const haptics::TissueVolume& after) const {
  // Finds the box around initial, final and target tissue.
  glm::ivec3 lo, hi;
  start_.bounds(lo, hi);
  const auto include = [&](const haptics::TissueVolume& other) {
    glm::ivec3 a, b;
    other.bounds(a, b);
    if (a.x > b.x) return;
    const auto to_start = [&](const glm::ivec3& v) {
      return glm::round(start_.frame().to_voxels(other.frame().to_world(dvec3(v))));
    };
    lo = glm::min(lo, glm::ivec3(to_start(a)));
    hi = glm::max(hi, glm::ivec3(to_start(b)));
  };
  include(after);
  if (ideal_) include(*ideal_);
  const dvec3 origin_W = start_.frame().to_world(dvec3(lo));
  const glm::ivec3 size = hi - lo + 1;
  // The samples of all volumes lie on one common grid, but each volume has its own origin.
  const auto copy_box = [&](const haptics::TissueVolume& volume) {
    return dense_copy(volume, glm::ivec3(glm::round(volume.frame().to_voxels(origin_W))), size);
  };
  session::Preparation in;
  DenseCopy before = copy_box(start_);
  in.frame = before.frame;
  if (task_) {
    in.axis_W = task_->axis_W;
    in.contour = task_->ideal && task_->ideal->has("unprepared");
  }
  in.keep = inside(protect_, before);
  in.before = std::move(before.field);
  in.tissue = std::move(before.tissue);
  in.after = copy_box(after).field;
  if (ideal_) in.ideal = copy_box(*ideal_).field;
  return cropped(in);
}

std::optional<session::Preparation> TaskEvaluator::judge(const haptics::TissueVolume& after,
                                                         session::ScoreInput& input) const {
  if (task_ && task_->explore) return std::nullopt;
  session::Preparation in = preparation(after);
  std::shared_ptr<const Reference> reference = reference_;
  if (!reference || reference->origin != in.frame.origin || reference->size != in.before.size) {
    reference.reset(new Reference{in.frame.origin, in.before.size, session::cavity_reference(in)});
    reference_ = reference;
  }
  const session::CavityAndIdeal measured = session::measure_against_ideal(in, reference->cavity);
  input.cavity = measured.result;
  input.cavity_ideal = measured.ideal;
  if (ideal_) input.ideal = ideal_->volumes();
  return in;
}

std::optional<session::ExploreMeter> TaskEvaluator::explore_meter() const {
  if (!task_ || !task_->explore) return std::nullopt;
  if (!task_->sites.empty()) return session::ExploreMeter(task_->sites, task_->axis_W, tip_);
  const DenseCopy copy = dense_copy(start_);
  return session::ExploreMeter(copy.frame, copy.field, copy.tissue, inside(region_, copy));
}

namespace {

/// Mean hardness of the removed part of each tissue. Empty if all tissue has full hardness.
std::optional<PerTissue> removed_hardness(const haptics::TissueVolume& start, const haptics::TissueVolume& after) {
  if (!start.graded()) return std::nullopt;
  const double voxel = start.frame().voxel, least = voxel * voxel * voxel;
  const PerTissue was = start.volumes(), is = after.volumes();
  const PerTissue hardness_was = start.hardness_volumes(), hardness_is = after.hardness_volumes();
  PerTissue mean{};
  for (std::size_t i = 1; i < mean.size(); ++i) {
    if (was[i] - is[i] > least) mean[i] = (hardness_was[i] - hardness_is[i]) / (was[i] - is[i]);
  }
  return mean;
}

session::Score score_of(const Scene& scene, const session::ScoreInput& input) {
  return session::score_of_scene(Json::parse(scene.text, scene.file.string()), input);
}

}  // namespace

session::Score final_score(const Scene& scene, const haptics::TissueVolume& after, FinishedHand hand) {
  const haptics::TissueVolume start = load_untouched(scene);
  const TaskEvaluator judge(scene, start);
  session::ScoreInput& input = hand.input;
  input.before = start.volumes();
  input.after = after.volumes();
  if (scene.implant && input.implant) measure_bed(*scene.implant, after, *input.implant);
  (void)judge.judge(after, input);
  if (!hand.explore) hand.explore = judge.explore_meter();
  if (hand.explore) {
    hand.explore->add(hand.unexplored);
    input.explore = hand.explore->result();
  }
  return score_of(scene, input);
}

EvaluatedSession evaluate_session(const session::SessionReader& session) {
  return evaluate_session(session, scene_of(session));
}

namespace {

/// State of a recording's water spray over time. Call sprays() with increasing times.
class Water {
 public:
  Water(const session::SessionReader& session, bool on) : stream_(session.stream("water")), on_(on) {}
  bool sprays(Nanos t) {
    for (; stream_ && next_ < stream_->t.size() && stream_->t[next_] <= t; ++next_)
      on_ = stream_->columns.front()[next_] > 0;
    return on_;
  }

 private:
  const session::StreamData* stream_;
  std::size_t next_ = 0;
  bool on_;
};

}  // namespace

EvaluatedSession evaluate_session(const session::SessionReader& session, Scene scene) {
  RecordedTissue recorded(session, scene, load_tissue(scene));
  std::vector<const Cut*> cuts;
  // A second thread applies the cuts, while this one computes the ideal and reads the ticks.
  auto carved = std::async(std::launch::async, [&] {
    recorded.seek(std::numeric_limits<Nanos>::max());
    cuts = recorded.cuts();
    recorded.carver().end_stroke();
    return recorded.carver().take_tissue();
  });
  haptics::TissueVolume start = load_untouched(scene);
  const TaskEvaluator judge(scene, start);
  const double rate = session.header().servo_rate;
  session::HandMeter hand(rate);
  auto explored = judge.explore_meter();
  auto damage = damage_meter(scene);
  auto heat = heat_meter(scene, start);
  Water water(session, scene.spray_on);
  std::optional<session::ImplantMeter> implant;
  if (scene.implant) implant.emplace(*scene.implant);
  session.each_piece([&](std::vector<ServoTick> ticks) {
    session::set_scored_times(ticks, rate);
    hand.add(ticks);
    if (explored) explored->add(ticks);
    if (damage) damage->add(ticks);
    for (std::size_t i = 0; heat && i < ticks.size(); ++i) heat->add({&ticks[i], 1}, water.sprays(ticks[i].t));
    if (implant) implant->add(ticks);
  });
  session::ScoreInput input = session::score_input(session, hand.result(), {});
  haptics::TissueVolume after = carved.get();
  input.before = start.volumes();  // of the tissue itself, because the volumes in the file may be wrong
  input.after = after.volumes();
  input.removed_hardness = removed_hardness(start, after);
  std::optional<session::Preparation> preparation = judge.judge(after, input);
  if (explored) input.explore = explored->result();
  if (damage) input.damage = damage->result();
  if (heat) input.heat = heat->result();
  if (implant) {
    input.implant = implant->result();
    measure_bed(*scene.implant, after, *input.implant);
  }
  session::Score score = score_of(scene, input);
  std::optional<haptics::TissueVolume> ideal;
  if (judge.ideal()) ideal = copy_of(*judge.ideal());
  return {std::move(scene),       std::move(start), std::move(after), std::move(ideal),
          std::move(preparation), std::move(input), std::move(score), std::move(cuts)};
}

}  // namespace typodont
