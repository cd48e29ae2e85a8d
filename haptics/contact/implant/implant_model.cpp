#include "haptics/contact/implant/implant_model.h"

#include <algorithm>
#include <cmath>

#include "haptics/coupling/passivity.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

namespace {

constexpr double kMinSpindleSpeed = 1e-3;  // rad/s; a slower spindle counts as at rest
// m; a tool whose tip is farther than this from the bed's axis does not cut
constexpr double kAtPlace = 2e-6;
// The tip counts as touching if the cosine between contact force and tool axis is larger than this.
constexpr double kTipContactCosine = 0.5;
constexpr int kMaxSteps = 8;             // largest number of steps of a tool in a tick (Zhao 2020, eq. 11)
constexpr double kFollowEnd = 1e-7;      // m; a proxy that moves by itself to a place nearer than this is put there
constexpr double kThreadGrips = 0.2e-3;  // m, depth of the tip at which a thread engages
// m; an implant counts as seated if it is nearer than this to its final depth or to the bottom of the bed
constexpr double kSeated = 0.05e-3;
// The motor has full speed up to the torque (1 - kSpeedHeldUpTo) × stall torque; above, its speed falls linearly to 0.
constexpr double kSpeedHeldUpTo = 0.1;
constexpr double kTorqueTime = 4e-3;  // s, time constant of the filter for the axial torque
// m, distance between samples along the axis when the depth of a bed is measured
constexpr double kAcross = 0.05e-3;

dvec3 axis_of(const dquat& R_WT) {
  return R_WT * dvec3(0, 0, -1);
}
double turn_about(const dvec3& axis, const dquat& from, const dquat& to) {
  return glm::dot(rotation_vector(from, to), axis);
}

}  // namespace

ImplantModel::ImplantModel(const ServoSettings& settings, const Parameters& parameters)
    : OffsetModel(settings), parameters_(parameters), beds_(parameters.beds) {
  beds_.reserve(kMaxBeds);
  for (const Tool& tool : tool_set(settings)) {
    voxels_.push_back(tool.implant ? make_tool_voxels(tool, parameters.tool_voxel) : ToolVoxels{});
    ends_.emplace_back(voxels_.back(), voxel());
  }
  law_.voxel = voxel();
  for (std::size_t t = 0; t < law_.energy.size(); ++t) law_.energy[t] = settings.materials[t].specific_energy;
  law_.grey_per_hardness.fill(parameters.tooth_grey);
  const auto set = [&](Tissue tissue, double grey, double per_hardness) {
    law_.grey[static_cast<std::size_t>(tissue)] = grey;
    law_.grey_per_hardness[static_cast<std::size_t>(tissue)] = per_hardness;
  };
  set(Tissue::kAir, 0, 0);
  set(Tissue::kCorticalBone, 0, parameters.cortical_grey);
  set(Tissue::kCancellousBone, 0, parameters.cancellous_grey);
  set(Tissue::kAmalgam, parameters.metal_grey, 0);
  set(Tissue::kPulp, parameters.soft_grey, 0);
  set(Tissue::kGingiva, parameters.soft_grey, 0);
  for (std::size_t t = 0; t < thread_resistance_.size(); ++t) {
    for (std::size_t byte = 0; byte < thread_resistance_[t].size(); ++byte) {
      const double hardness = hardness_fraction(static_cast<std::uint8_t>(byte));
      const double grey = law_.grey[t] + law_.grey_per_hardness[t] * hardness;
      thread_resistance_[t][byte] = std::pow(grey / parameters.torque_grey, parameters.torque_exponent);
    }
  }
  for (std::size_t i = 0; i < around_thread_.size(); ++i) {
    const double a = 2 * kPi * static_cast<double>(i) / static_cast<double>(around_thread_.size());
    around_thread_[i] = {std::cos(a), std::sin(a), 0};
  }
}

double ImplantModel::clearance(const Pose& X_WG) noexcept {
  return in_bed_ || blended_ || placed_ ? 0 : OffsetModel::clearance(X_WG);
}

void ImplantModel::begin_anew() noexcept {
  OffsetModel::begin_anew();
  in_bed_ = blended_ = switched_ = false;
  offset_ = dvec3(0);
  turn_ = dquat(1, 0, 0, 0);
  torque_ = 0;
  motion_ = Motion::kFree;
}

/// Returns false while a drill is in an implant bed: the drill must be withdrawn first. A placed implant stays in the
/// bone, so another tool can be taken then.
bool ImplantModel::is_free(std::uint32_t which, const Pose& X_WG) noexcept {
  return !in_bed_ && !blended_ && OffsetModel::is_free(which, X_WG);
}

void ImplantModel::take_up(std::uint32_t which) noexcept {
  OffsetModel::take_up(which);
  placed_ = seated_ = false;
  axial_ = {};
}

double ImplantModel::stiffness(const ContactInput& in) const noexcept {
  return settings_.stiffness * std::max(in.last.relative_stiffness, 1e-3);
}

/// Returns true if the spindle rotates forward, as cutting requires.
bool ImplantModel::tool_cuts(const ContactInput& in) const noexcept {
  return in.removal.cuts && in.removal.spindle > kMinSpindleSpeed;
}

bool ImplantModel::patch_holds(const dvec3& p_W) const noexcept {
  return patch_.holds(settings_.frame.to_voxels(p_W), reach_now());
}

dquat ImplantModel::turned_into(const Bed& bed, const dquat& R_WT) const noexcept {
  return glm::normalize(rotation_between(axis_of(R_WT), bed.axis_W) * R_WT);
}

Pose ImplantModel::tool_in_bed(const Bed& bed, double tip) const noexcept {
  return {bed.entry_W + (tip - tool().half()) * bed.axis_W, {}};
}

/// Evaluates the voxels at the tool's end.
EndScan ImplantModel::scan_ahead(const Pose& X_WT, bool cuts, double speed, double widest) const noexcept {
  const ImplantTool& implant = *tool().implant;
  EndLaw law = law_;
  // Radius in which voxels can stop the tool. One voxel narrower than the tool: an equally wide bed does not stop it.
  law.width = std::min((implant.threaded() ? implant.core_diameter : tool().diameter) / 2, widest) - voxel();
  law.cuts = cuts;
  law.max_grey = implant.max_grey;
  law.speed = speed;
  law.thrust_ratio = implant.thrust_ratio;
  return scan_end(ends_[tool_], patch_, law, settings_.frame.to_voxels(X_WT.p), X_WT.R);
}

/// Measures the depth of a bed along its axis, in m. The stored depth may be too large after an undo.
double ImplantModel::bed_depth(const Bed& bed) const noexcept {
  if (bed.bore) {
    const dvec3 below = bed.entry_W + 0.5 * bed.depth * bed.axis_W;
    return tissue_at(below) == kPlacedTissue ? bed.depth : 0;
  }
  constexpr double kInBone = -0.5;  // voxels; a lower distance is inside bone
  for (double s = kAcross; s < bed.depth; s += kAcross) {
    const dvec3 p_V = settings_.frame.to_voxels(bed.entry_W + s * bed.axis_W);
    if (!patch_.holds(p_V, 1)) return s;
    if (sample_linear(patch_, p_V) < kInBone) return s - kAcross;
  }
  return bed.depth;
}

void ImplantModel::constrain(const ContactInput& in, Contact& out) noexcept {
  motion_ = Motion::kFree;
  if (!tool().implant) {
    OffsetModel::constrain(in, out);
    last_ = {out.p_WG, in.X_WT.R};
    return;
  }
  if (!blended_ && !in_bed_) last_ = in.X_WG;
  if (in_bed_) {
    constrain_in_bed(in, out);
  } else {
    constrain_free(in, out);
    if (!placed_ && enter_bed(in, out)) constrain_in_bed(in, out);
    if (placed_) motion_ = Motion::kPlaced;
  }
  last_R_hand_ = in.X_WT.R;
  out.level = static_cast<std::uint32_t>(motion_);
}

/// Largest motion (m) in this tick of a proxy that moves by itself to a place `left` m away: it changes the force of
/// spring and damper by at most switch_slew. `speed`: m/s of this motion; updated.
double ImplantModel::own_step(const ContactInput& in, double left, double& speed) const noexcept {
  const double k = stiffness(in), b = settings_.damping, slew = parameters_.switch_slew;
  if (b > 0) {
    // Half of the change for the spring, half for the damper, whose force follows the speed.
    speed = std::min({0.5 * slew / k, speed + 0.5 * slew / b * in.dt, left / std::max(b / k, in.dt)});
  } else {
    speed = slew / k;
  }
  return left < kFollowEnd ? left : speed * in.dt;
}

/// Reduces the pose's jump (offset_, turn_) that remains from entering or leaving a bed, and adds it to the pose.
void ImplantModel::blend(const ContactInput& in, Contact& out, const Pose& state) noexcept {
  const double length = glm::length(offset_), most = own_step(in, length, offset_speed_);
  offset_ = length > most ? offset_ * (1 - most / length) : dvec3(0);
  const dvec3 turn = rotation_vector(dquat(1, 0, 0, 0), turn_);
  const double angle = glm::length(turn), max_turn = parameters_.turn_slew * in.dt;
  turn_ = angle > max_turn ? glm::angleAxis(angle - max_turn, turn / angle) : dquat(1, 0, 0, 0);
  blended_ = offset_ != dvec3(0) || angle > max_turn;
  out.p_WG = state.p + offset_;
  out.orientation.held = in_bed_ || blended_;
  if (out.orientation.held) {
    out.orientation.R_WG = glm::normalize(turn_ * state.R);
    const dvec3 held = rotation_vector(in.X_WT.R, out.orientation.R_WG);
    out.spring.torque = parameters_.turn_stiffness * held;
    out.spring.stored = parameters_.turn_stiffness * glm::dot(held, held) / 2;
  }
  if (blended_) out.touching = true, out.settled = false;
  last_ = {out.p_WG, out.orientation.held ? out.orientation.R_WG : in.X_WT.R};
}

/// Returns true if the tissue below a contact of the last tick is too dense for the tool.
bool ImplantModel::touches_too_dense() const noexcept {
  for (int i = 0; i < contacts_.own(); ++i) {
    const dvec3 p_V = contacts_.below(i);
    if (!patch_.holds(p_V, 1)) continue;
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    const double grey = law_.grey[tissue] + law_.grey_per_hardness[tissue] * hardness_at(patch_, p_V);
    if (grey > tool().implant->max_grey) return true;
  }
  return false;
}

void ImplantModel::constrain_free(const ContactInput& in, Contact& out) noexcept {
  ContactInput free = in;
  // Outside an implant bed, only a round bur cuts, and only after the blending of the pose at the bed has ended.
  cuts_free_ = in.removal.cuts && tool().implant->kind == ImplantToolKind::kRound && !blended_ && !touches_too_dense();
  free.removal.cuts = cuts_free_;
  if (blended_) free.X_WG.p = in.X_WG.p - (switched_ ? dvec3(0) : offset_);
  if (placed_) {
    out.p_WG = in.X_WT.p;
    out.settled = false;
  } else {
    OffsetModel::constrain(free, out);
  }
  if (switched_) offset_ = last_.p - out.p_WG;
  switched_ = false;
  if (blended_) {
    blend(in, out, {out.p_WG, in.X_WT.R});
  } else {
    last_ = {out.p_WG, in.X_WT.R};
  }
}

/// Enters an implant bed (drilled hole) if the criteria in bed_criteria.h are met. Returns true if the tool entered.
bool ImplantModel::enter_bed(const ContactInput& in, const Contact& out) noexcept {
  const ImplantTool& implant = *tool().implant;
  if (implant.kind == ImplantToolKind::kRound || blended_ || out.gap.lost || out.deep) return false;
  const dvec3 axis = axis_of(in.X_WT.R), tip = out.p_WG + tool().half() * axis;
  const double force = stiffness(in) * glm::dot(in.X_WT.p - out.p_WG, axis);
  const double radius = implant.threaded() ? implant.core_diameter / 2 : tool().radius();
  BedCriteria met;
  met.pushed = out.touching && force > parameters_.enter_force;
  const bool widens = (implant.kind == ImplantToolKind::kDrill && in.removal.spindle > kMinSpindleSpeed) ||
                      implant.kind == ImplantToolKind::kImplant;
  for (std::size_t i = 0; i < beds_.size(); ++i) {
    const Bed& bed = beds_[i];
    if (bed.bore != (implant.kind == ImplantToolKind::kScrew)) continue;
    const dvec3 from_entry = tip - bed.entry_W;
    const double along = glm::dot(from_entry, bed.axis_W);
    const double aside = glm::length(from_entry - along * bed.axis_W);
    met.at_centre =
        aside < parameters_.centre_tolerance && along < parameters_.centre_tolerance && along > -parameters_.rim_above;
    const double wider = radius - bed.radius;
    met.fits = wider <= (widens ? parameters_.widening : parameters_.radius_tolerance) && wider >= -parameters_.loose;
    met.aligned = std::acos(std::clamp(glm::dot(axis, bed.axis_W), -1.0, 1.0)) < parameters_.axis_tolerance;
    // The tip may also slide into the bed without touching its rim; the axial force is then too small for decide().
    const bool slid_in = aside < parameters_.centre_tolerance && met.fits && met.aligned &&
                         along > parameters_.centre_tolerance && along < bed.depth;
    if (!slid_in && decide(met, false) != BedDecision::kEnterBed) continue;
    const double depth = bed_depth(bed);
    if (depth < parameters_.min_depth) continue;
    if (!bed.bore) beds_[i].depth = depth;
    // Starts from the last tick's pose, because the current pose may have jumped at the rim.
    begin_bed_motion(i, along, {in.X_WG.p, in.X_WT.R}, in.X_WT.R);
    return true;
  }
  const double push = glm::length(in.X_WT.p - out.p_WG);
  const bool on_tip = push > 0 && glm::dot(in.X_WT.p - out.p_WG, axis) > kTipContactCosine * push;
  bool can_begin = implant.kind == ImplantToolKind::kDrill && implant.centre_ability > 0 && tool_cuts(in) && on_tip;
  if (decide({false, false, false, met.pushed}, can_begin) != BedDecision::kBeginBed) return false;
  if (beds_.size() >= kMaxBeds || !patch_holds(out.p_WG)) return false;
  can_begin = scan_ahead({out.p_WG, in.X_WT.R}, true, in.removal.spindle).max_grey <= implant.max_grey;
  if (!can_begin) return false;
  beds_.push_back({tip, axis, 0, radius, 0, false});
  begin_bed_motion(beds_.size() - 1, 0, {in.X_WG.p, in.X_WT.R}, in.X_WT.R);
  return true;
}

void ImplantModel::begin_bed_motion(std::size_t bed, double tip, const Pose& from, const dquat& R_hand) noexcept {
  in_bed_ = true;
  bed_ = bed;
  tip_ = entered_ = tip;
  easing_ = true;
  easing_speed_ = offset_speed_ = 0;
  axial_ = {};
  torque_ = 0;
  const dquat R = turned_into(beds_[bed], R_hand);
  offset_ = from.p - tool_in_bed(beds_[bed], tip).p;
  turn_ = glm::normalize(from.R * glm::conjugate(R));
  blended_ = true;
}

/// Ends the motion in a bed. The tool is then free, and its pose changes gradually to the free pose.
void ImplantModel::end_bed_motion(const ContactInput& in) noexcept {
  in_bed_ = false;
  motion_ = Motion::kFree;
  OffsetModel::begin_anew();
  OffsetModel::release();
  turn_ = glm::normalize(last_.R * glm::conjugate(in.X_WT.R));
  blended_ = switched_ = true;
  offset_speed_ = 0;
  if (!beds_[bed_].bore && beds_[bed_].depth < parameters_.min_depth && bed_ + 1 == beds_.size() &&
      beds_.size() > parameters_.beds.size()) {
    beds_.pop_back();
  }
}

void ImplantModel::constrain_in_bed(const ContactInput& in, Contact& out) noexcept {
  const Bed& bed = beds_[bed_];
  const double hand = glm::dot(in.X_WT.p - bed.entry_W, bed.axis_W) + tool().half();
  out = {};
  out.touching = true;
  out.settled = false;
  scan_ = {};
  motion_ = Motion::kSliding;
  if (!patch_holds(last_.p)) {
    out.faults |= bits(Fault::kPatchEdge);
  } else {
    tip_ += tool().implant->threaded() ? screw(in, bed, hand - tip_, out) : advance(in, bed, hand - tip_, out);
  }
  Bed& now = beds_[bed_];
  if (motion_ == Motion::kDrilling || motion_ == Motion::kPerforating) {
    now.depth = std::max(now.depth, tip_);
    now.radius = std::max(now.radius, tool().radius());
  }
  if (tool().implant->kind == ImplantToolKind::kTap) now.tapped = std::max(now.tapped, tip_);
  if (tip_ < std::min(0.0, entered_) - parameters_.leave) {
    end_bed_motion(in);
    // The tool has left the implant bed (drilled hole), so it follows the hand.
    out = {};
    constrain_free(in, out);
    return;
  }
  const dquat R = turned_into(now, in.X_WT.R);
  blend(in, out, {tool_in_bed(now, tip_).p, R});
  const double torque = glm::dot(scan_.wrench.torque, dvec3(0, 0, 1)) * std::max(0.0, axial_.speed);
  torque_ += ((motion_ == Motion::kScrewing ? torque_ : torque) - torque_) * (1 - std::exp(-in.dt / kTorqueTime));
  out.orientation.spindle_torque = torque_ * (out.orientation.R_WG * dvec3(0, 0, 1));
  out.area = scan_.engaged;
}

/// Axial motion in this tick of a drill or a depth gauge, m. `wanted`: motion to the hand, m.
double ImplantModel::advance(const ContactInput& in, const Bed& bed, double wanted, Contact&) noexcept {
  // Cuts only if the tip is on the axis; otherwise the entry would become oval.
  const bool cuts = tool_cuts(in) && glm::length(offset_) < kAtPlace && turn_ == dquat(1, 0, 0, 0);
  const Pose here{tool_in_bed(bed, tip_).p, turned_into(bed, in.X_WT.R)};
  scan_ = scan_ahead(here, cuts, in.removal.spindle);
  const bool in_old_bed = tip_ < bed.depth - voxel();
  if (scan_.engaged > 0 && cuts && scan_.free > 0) {
    motion_ = Motion::kDrilling;
  } else if (scan_.engaged <= 0 && !in_old_bed && bed.depth > 0 && tool_cuts(in)) {
    motion_ = Motion::kPerforating;
  }
  // Cutting force acts only inward, not on withdrawal.
  const double drag = parameters_.sliding_drag + (wanted > 0 ? scan_.wrench.force.z : 0);
  const double moved = coupled_step(wanted, stiffness(in), parameters_.mass, drag, in.dt, axial_);
  if (motion_ == Motion::kDrilling) easing_ = false;
  const double longest = parameters_.steps * voxel();
  double step = allowed_step(moved, scan_.free, longest, scan_.collided > 0, parameters_.as_printed);
  // Eq. 11: several steps in a tick, while the tool touches nothing.
  for (int i = 1; i < kMaxSteps && scan_.engaged <= 0 && std::abs(step) >= i * longest; ++i) {
    const Pose ahead{tool_in_bed(bed, tip_ + step).p, here.R};
    if (!patch_holds(ahead.p)) break;
    const EndScan next = step > 0 ? scan_ahead(ahead, cuts, in.removal.spindle) : EndScan{};
    if (next.engaged > 0) break;
    step += allowed_step(moved - step, next.free, longest, false, parameters_.as_printed);
  }
  step = eased(in, bed, wanted, step);
  axial_.speed = step / in.dt;
  return step;
}

/// Limits the step by switch_slew after the tool has entered a bed, until it drills or has caught up with the hand.
double ImplantModel::eased(const ContactInput& in, const Bed& bed, double wanted, double step) noexcept {
  if (!easing_) return step;
  // First the tool comes to the bed's axis (offset_), then it follows the hand along the axis.
  const double max_step = offset_ == dvec3(0) ? own_step(in, std::abs(wanted), easing_speed_) : 0;
  const double own = glm::dot(in.moved, bed.axis_W);
  const double slow = std::clamp(step, std::min(own, 0.0) - max_step, std::max(own, 0.0) + max_step);
  if (max_step > 0 && std::abs(wanted - slow) <= 0.5 * parameters_.switch_slew * in.dt / stiffness(in)) easing_ = false;
  return slow;
}

/// Axial motion of a thread cutter, implant or screw in this tick, m: one pitch per turn once the thread has engaged.
/// `wanted`: motion to the hand, m.
double ImplantModel::screw(const ContactInput& in, const Bed& bed, double wanted, Contact& out) noexcept {
  const ImplantTool& implant = *tool().implant;
  const double torque = thread_torque(bed, tip_);
  const double most = parameters_.steps * voxel();
  double turn;  // rad, rotation of the tool in this tick; positive: clockwise
  if (implant.by_hand) {
    turn = turn_about(bed.axis_W, last_R_hand_, in.X_WT.R);
  } else {
    const double stall = settings_.spindle.stall_torque;
    const double turns = stall > 0 ? std::clamp((1 - torque / stall) / kSpeedHeldUpTo, 0.0, 1.0) : 1.0;
    turn = in.removal.spindle * (in.removal.spindle > 0 ? turns : 1.0) * in.dt;
  }
  const Pose here{tool_in_bed(bed, tip_).p, turned_into(bed, in.X_WT.R)};
  // The core of an implant displaces the wall of a narrower bed.
  scan_ = bed.bore ? EndScan{} : scan_ahead(here, false, 1, bed.radius);
  if (bed.bore) scan_.free = std::max(0.0, bed.depth - tip_);
  if (tip_ < kThreadGrips) {
    // Before the thread engages, the tool slides. If it is turned forward and pushed, it is drawn in.
    const double drawn = turn > 0 && wanted > 0 ? implant.pitch * turn / (2 * kPi) : 0;
    const double slides = wanted < 0 ? wanted : std::max(std::min(wanted, -tip_), drawn);
    motion_ = drawn > 0 ? Motion::kScrewing : Motion::kSliding;
    const double step = eased(in, bed, wanted, std::clamp(std::min(slides, scan_.free), -most, most));
    axial_.speed = step / in.dt;
    return step;
  }
  motion_ = Motion::kScrewing;
  const double drawn = implant.pitch * turn / (2 * kPi);
  const double step = std::clamp(std::min(drawn, scan_.free), -most, most);
  axial_.speed = step / in.dt;
  // The felt torque opposes the rotation. A tool that advances rotates about -z if turned by hand, +z with a motor.
  const double against = implant.by_hand ? 1 : -1;
  const double felt = turn == 0 ? 0 : against * (turn > 0 ? torque : -parameters_.tapped_fraction * torque);
  torque_ += (felt - torque_) * (1 - std::exp(-in.dt / kTorqueTime));
  // The implant is seated if it is completely in bone, or at the bottom of a shallow bed.
  const bool at_bottom = scan_.free - step < kSeated && (bed.bore || tip_ > 0.5 * tool().length);
  const bool home = tip_ + step >= tool().length - kSeated || at_bottom;
  if (implant.stays() && home && turn > 0 && !seated_) out.places = true;
  return step;
}

/// Torque of the thread in N·m when the tip is at the depth `tip` (m) in the bed (README.md, "Insertion torque").
double ImplantModel::thread_torque(const Bed& bed, double tip) const noexcept {
  if (bed.bore) return 0;
  constexpr double kApart = 1e-3;  // m, distance along the axis between samples
  const double r = tool().radius(), core = tool().implant->core_diameter / 2, outward = r - 0.5 * (r - core);
  const dquat R = rotation_between({0, 0, -1}, bed.axis_W);
  double sum = 0;
  for (double s = std::max(0.5 * kApart, tip - tool().length); s < tip; s += kApart) {
    for (const dvec3& around : around_thread_) {
      const dvec3 p_W = bed.entry_W + s * bed.axis_W + R * (outward * around);
      const dvec3 p_V = settings_.frame.to_voxels(p_W);
      if (!patch_.holds(p_V, 1) || sample_linear(patch_, p_V) > 0) continue;
      const glm::ivec3 nearest(p_V - dvec3(patch_.lo) + 0.5);
      const std::size_t at = patch_.at(nearest.x, nearest.y, nearest.z);
      const std::uint8_t hardness = patch_.hardness.empty() ? kOwnHardness : felt_hardness(patch_, at);
      const double fraction = s < bed.tapped ? parameters_.tapped_fraction : 1;
      sum += fraction * thread_resistance_[static_cast<std::size_t>(shown(patch_.tissue[at]))][hardness];
    }
  }
  const double surface = 2 * kPi * r * kApart / static_cast<double>(around_thread_.size());
  const double lever = r / 2e-3;  // the implant's radius divided by the reference radius (2 mm)
  // volume of bone that the thread displaces, divided by the volume in a bed as wide as the core
  const auto displaced = [&](double bore) { return outward * outward - bore * bore; };
  const double narrow = displaced(std::min(bed.radius, core)) / displaced(core);
  return parameters_.torque * sum * surface / parameters_.torque_surface * lever * narrow;
}

bool ImplantModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  if (!tool().implant) return OffsetModel::cut(in, contact, cut, energy);
  const double h = voxel();
  if (contact.places) {
    const Pose X_WG{contact.p_WG, contact.orientation.R_WG};
    ++cut_count_;
    cut.X_WA = cut.X_WB = X_WG;
    cut.fill_radius = tool().radius();
    const dvec3 center = settings_.frame.to_voxels(X_WG.p);
    const double reach = tool().reach() / h + static_cast<double>(Sweep::kMargin);
    log_.add(cut_count_, glm::ivec3(glm::floor(center - reach)), glm::ivec3(glm::ceil(center + reach)),
             {X_WG, X_WG, tool_, false, tool().radius(), {}});
    const ImplantTool& implant = *tool().implant;
    const Bed& bed = beds_[bed_];
    if (implant.bore_depth > 0 && beds_.size() < kMaxBeds) {
      beds_.push_back({bed.entry_W + (tip_ - tool().length) * bed.axis_W, bed.axis_W, implant.bore_depth,
                       implant.bore_diameter / 2, 0, true});
    }
    seated_ = placed_ = true;
    last_ = X_WG;
    end_bed_motion(in);
    return true;
  }
  if (!in_bed_) return cuts_free_ && OffsetModel::cut(in, contact, cut, energy);
  if (motion_ != Motion::kDrilling) return false;
  return remove_sweep(in, {contact.p_WG, contact.orientation.R_WG}, cut, energy);
}

/// Repeats a cut; a placed implant is already in the snapshot.
PerTissue ImplantModel::repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept {
  return made.fill_radius > 0 ? PerTissue{} : OffsetModel::repeat(made, index, fresh);
}

/// Torque of a round bur: the sum of the cutting law over all its outer voxels.
void ImplantModel::feel_teeth_turn(const ContactInput& in, const Contact& contact) noexcept {
  const dvec3 motion = contact.p_WG - in.X_WG.p;
  const double speed = glm::length(motion) / in.dt;
  torque_ *= std::exp(-in.dt / kTorqueTime);
  if (!(tool_cuts(in) && speed > 0) || !patch_holds(contact.p_WG)) return;
  const ToolVoxels& voxels = voxels_[tool_];
  const double h = voxel();
  const dvec3 center = settings_.frame.to_voxels(contact.p_WG),
              along = glm::conjugate(in.X_WT.R) * (motion / glm::length(motion));
  const glm::dmat3 R = glm::mat3_cast(in.X_WT.R) / h;
  CuttingWrench sum;
  for (const ToolVoxel& v : voxels.outer) {
    if (glm::dot(dvec3(v.n), along) <= 0) continue;
    const dvec3 p_V = center + R * dvec3(v.p);
    const double gap = sample_linear(patch_, p_V) * h + static_cast<double>(v.outside);
    if (!(gap < h) || v.ability <= 0) continue;
    const double u = specific_energy_at(p_V);
    add_cutting(v, u * std::min(1.0, 1 - gap / h), along, in.removal.spindle, tool().implant->thrust_ratio, sum);
  }
  torque_ += (sum.torque.z * speed - torque_) * (1 - std::exp(-in.dt / kTorqueTime));
}

/// If no bone is ahead, reads the tissue of the bed's wall beside the tip. Returns the number of samples with tissue.
double ImplantModel::scan_wall(const Contact& contact) noexcept {
  constexpr int kAround = 8;
  const double h = voxel(), behind = tool().radius() + h;
  double total = 0;
  for (int i = 0; i < kAround; ++i) {
    const double a = 2 * kPi * i / kAround, z = h - tool().half();
    const dvec3 p_V = settings_.frame.to_voxels(
        contact.p_WG + contact.orientation.R_WG * dvec3(behind * std::cos(a), behind * std::sin(a), z));
    const auto tissue = static_cast<std::size_t>(haptics::tissue_at(patch_, p_V));
    if (tissue == 0) continue;
    scan_.tissue[tissue] += 1;
    scan_.hardness[tissue] += hardness_at(patch_, p_V);
    total += 1;
  }
  return total;
}

void ImplantModel::feel(const ContactInput& in, Contact& contact, Felt& out) noexcept {
  if (!in_bed_) {
    if (!placed_) OffsetModel::feel(in, contact, out);
    if (tool().implant && tool().implant->kind == ImplantToolKind::kRound && in.removal.cuts && !placed_) {
      feel_teeth_turn(in, contact);
      if (torque_ != 0 && !contact.orientation.held) {
        contact.orientation.held = true;
        contact.orientation.R_WG = in.X_WT.R;
      }
      contact.orientation.spindle_torque = torque_ * (in.X_WT.R * dvec3(0, 0, 1));
    }
    return;
  }
  // Only the axial torque is computed, not the forces of the bed's wall.
  out.turns_tool = true;
  out.unit = voxel();
  out.count = out.own = 2;
  double total = 0;
  for (const double area : scan_.tissue) total += area;
  if (!(total > 0)) total = scan_wall(contact);
  if (!(total > 0)) return;
  out.tissue = scan_.tissue;
  out.hardness = scan_.hardness;
  out.average(total, !patch_.hardness.empty());
}

}  // namespace typodont::haptics::implant
