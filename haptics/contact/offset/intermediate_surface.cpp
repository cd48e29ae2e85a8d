#include "haptics/contact/offset/intermediate_surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::offset {

namespace {

constexpr int kSide = PatchStep::kSide;
// Largest number of leaves (8³ samples) that change gradually; this takes about 0.1 ms per tick. Others change at once.
constexpr std::size_t kMaxMoving = 4096;

/// For each row of eight samples in a leaf, calls visit(index of its first sample in the patch, index in the leaf).
template <class Visit>
void for_rows(const TissuePatch& patch, const glm::ivec3& leaf, Visit visit) noexcept {
  const glm::ivec3 at = leaf - patch.lo;
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      visit(patch.at(at.x + x, at.y + y, at.z), static_cast<std::size_t>((x * kSide + y) * kSide));
}

bool holds_leaf(const TissuePatch& patch, const glm::ivec3& leaf) noexcept {
  return glm::all(glm::greaterThanEqual(leaf, patch.lo)) && glm::all(glm::lessThan(leaf, patch.lo + patch.n));
}

/// Calls visit(leaf) for the leaves of the patch that may contain a changed sample or label.
template <class Visit>
void for_leaves(const TissuePatch& patch, const glm::ivec3& changed_lo, const glm::ivec3& changed_hi,
                Visit visit) noexcept {
  const glm::ivec3 lo = glm::max(changed_lo, patch.lo + 1) - 1 & -kSide;
  const glm::ivec3 hi = glm::min(changed_hi, patch.lo + patch.n - 2) + 1;
  for (int x = lo.x; x <= hi.x; x += kSide)
    for (int y = lo.y; y <= hi.y; y += kSide)
      for (int z = lo.z; z <= hi.z; z += kSide) visit(glm::ivec3(x, y, z));
}

/// Changes each distance of a leaf towards its target by at most `step` (voxels). Returns true if all have reached it.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool approach(float* field, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y, const float* target, float step) {
  I8 moving{};
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y, target += kSide) {
      F8& row = *reinterpret_cast<F8*>(field + x * stride_x + y * stride_y);
      const F8 to = *reinterpret_cast<const F8*>(target), low = row - step, high = row + step;
      const F8 next = to < low ? low : to > high ? high : to;
      moving |= next != to;
      row = next;
    }
  }
  return !any_of(moving);
}

}  // namespace

IntermediateModel::IntermediateModel(const ServoSettings& settings, const IntermediateSurface& parameters,
                                     bool mean_stiffness)
    : parameters_(parameters), voxel_(settings.frame.voxel), cutter_(settings), felt_(settings, mean_stiffness) {
  felt_.set_speed(parameters.max_speed);
  const auto edge = static_cast<std::size_t>(patch_edge_for(tool_set(settings), voxel_) / kSide);
  slots_.resize(edge * edge * edge);
  moving_.reserve(std::min(slots_.size(), kMaxMoving));
}

/// Lends the coarse tissue patch of the model cutter_ (for contacts of the shank) to the model felt_ during `call`.
template <class Call>
auto IntermediateModel::with_shank(Call call) noexcept {
  struct Loan {
    std::vector<TissuePatch>&from, &to;
    Loan(std::vector<TissuePatch>& a, std::vector<TissuePatch>& b) noexcept : from(a), to(b) { from.swap(to); }
    ~Loan() { from.swap(to); }
  } const loan(cutter_.patch_.coarse_levels, felt_.patch_.coarse_levels);
  return call();
}

/// Element of slots_ for a leaf, from the leaf's position modulo the patch's edge. Leaves of one patch never share it.
std::uint32_t& IntermediateModel::slot_of(const glm::ivec3& leaf) noexcept {
  const int edge = felt_.patch_.n / kSide;
  const glm::ivec3 at = ((leaf / kSide) % edge + edge) % edge;
  return slots_[static_cast<std::size_t>((at.x * edge + at.y) * edge + at.z)];
}

double IntermediateModel::clearance(const Pose& X_WG) noexcept {
  if (!settled()) return 0;
  return std::min(cutter_.clearance(X_WG), with_shank([&] { return felt_.clearance(X_WG); }));
}

void IntermediateModel::begin_anew() noexcept {
  cutter_.begin_anew();
  felt_.begin_anew();
  has_pose_ = false;
}

void IntermediateModel::release() noexcept {
  cutter_.release();
  felt_.release();
}

bool IntermediateModel::is_free(std::uint32_t tool, const Pose& X_WG) noexcept {
  return settled() && cutter_.is_free(tool, X_WG) && with_shank([&] { return felt_.is_free(tool, X_WG); });
}

void IntermediateModel::take_up(std::uint32_t tool) noexcept {
  cutter_.take_up(tool);
  felt_.take_up(tool);
}

/// Takes over a new tissue patch. Where the surface that the hand feels may differ from the tissue, felt_ keeps its own
/// samples. So a PatchStep and a complete tissue patch give bit-identical results.
void IntermediateModel::adopt(Snapshot& fresh, PerTissue& removed) noexcept {
  PerTissue ignored{};
  handed_over_ = std::min(handed_over_, fresh.cuts);
  if (fresh.from != 0) {
    cutter_.adopt(fresh, removed);
    felt_.adopt(fresh, ignored);
    // Both adopt() calls swapped coarse patches with `fresh`. Only cutter_ keeps some, so the second swap is undone.
    felt_.patch_.coarse_levels.swap(static_cast<TissuePatch&>(fresh).coarse_levels);
  } else {
    auto& copy = static_cast<TissuePatch&>(fresh).intermediate.front();
    static_cast<Snapshot&>(copy) = fresh;
    felt_.adopt(copy, ignored);
    const bool first = cutter_.patch_.number == 0;
    const bool edited = fresh.edits != cutter_.patch_.edits || fresh.pieces != cutter_.patch_.pieces;
    cutter_.adopt(fresh, removed);
    const TissuePatch& old = cutter_.patch_.intermediate.front();  // the tissue patch that felt_ used until now
    glm::ivec3 lo, hi;
    bool filled = false;
    if (!first && cutter_.log_.since(handed_over_, lo, hi, filled))
      for_leaves(felt_.patch_, lo, hi, [&](const glm::ivec3& leaf) { keep_leaf(old, leaf); });
    for (Moving& leaf : moving_) {
      keep_leaf(old, leaf.lo);
      if (edited && holds_leaf(felt_.patch_, leaf.lo)) load_target(leaf);
    }
  }
  for (std::size_t i = moving_.size(); i-- > 0;)
    if (!holds_leaf(felt_.patch_, moving_[i].lo)) drop(i);
  copy_marks();
}

/// Copies a leaf from `old` to the tissue patch of the model felt_, if both patches contain the leaf.
void IntermediateModel::keep_leaf(const TissuePatch& old, const glm::ivec3& leaf) noexcept {
  TissuePatch& felt = felt_.patch_;
  if (!holds_leaf(old, leaf) || !holds_leaf(felt, leaf)) return;
  const std::size_t from = old.at(leaf.x - old.lo.x, leaf.y - old.lo.y, leaf.z - old.lo.z);
  const std::size_t to = felt.at(leaf.x - felt.lo.x, leaf.y - felt.lo.y, leaf.z - felt.lo.z);
  for_rows(felt, leaf, [&](std::size_t row, std::size_t) {
    std::copy_n(old.distance.data() + (from + row - to), kSide, felt.distance.data() + row);
    std::copy_n(old.tissue.data() + (from + row - to), kSide, felt.tissue.data() + row);
  });
}

/// Copies the boxes of cuts and fillings from the tissue patch of the model cutter_ to that of the model felt_.
void IntermediateModel::copy_marks() noexcept {
  const TissuePatch& from = cutter_.patch_;
  TissuePatch& to = felt_.patch_;
  to.exact_outside = from.exact_outside;
  to.cut_lo = from.cut_lo, to.cut_hi = from.cut_hi;
  to.filled_lo = from.filled_lo, to.filled_hi = from.filled_hi;
}

/// Makes the current tissue the target of the surface that the hand feels. Where this surface is still moving to an
/// earlier target, it moves on from its current position.
void IntermediateModel::hand_over() noexcept {
  glm::ivec3 lo, hi;
  bool filled = false;
  if (!cutter_.log_.since(handed_over_, lo, hi, filled)) return;
  handed_over_ = cutter_.log_.last();
  copy_marks();
  for_leaves(felt_.patch_, lo, hi, [&](const glm::ivec3& leaf) { aim(leaf); });
}

void IntermediateModel::aim(const glm::ivec3& leaf) noexcept {
  std::uint32_t& slot = slot_of(leaf);
  if (slot == 0) {
    if (moving_.size() == moving_.capacity()) return keep_leaf(cutter_.patch_, leaf);
    moving_.emplace_back().lo = leaf;
    slot = static_cast<std::uint32_t>(moving_.size());
  }
  load_target(moving_[slot - 1]);
}

void IntermediateModel::load_target(Moving& leaf) noexcept {
  const TissuePatch& from = cutter_.patch_;
  for_rows(from, leaf.lo, [&](std::size_t row, std::size_t at) {
    std::copy_n(from.distance.data() + row, kSide, leaf.target + at);
    std::copy_n(from.tissue.data() + row, kSide, leaf.labels + at);
    // Filled samples get their label at once, so that the surface of a growing filling is felt as filling.
    for (std::size_t i = 0; i < kSide; ++i)
      if (is_filled(leaf.labels[at + i])) felt_.patch_.tissue[row + i] = leaf.labels[at + i];
  });
}

/// Speed at which the surface that the hand feels moves to the surface of the tissue, m/s.
double IntermediateModel::speed(const ContactInput& in) const noexcept {
  const double resistance = area_ * in.last.relative_stiffness;
  return in.last.normal_force > 0 && resistance > 0
             ? std::min(parameters_.removal * in.last.normal_force / resistance, parameters_.max_speed)
             : parameters_.max_speed;
}

void IntermediateModel::animate(const ContactInput& in) noexcept {
  if (moving_.empty()) return;
  felt_.forget_creases();
  const auto step = static_cast<float>(speed(in) * in.dt / voxel_);
  for (std::size_t i = moving_.size(); i-- > 0;)
    if (advance(moving_[i], step)) drop(i);
}

/// Moves each distance in a leaf of the model felt_ towards its target by at most `step` (voxels). True: all arrived.
bool IntermediateModel::advance(const Moving& leaf, float step) noexcept {
  TissuePatch& felt = felt_.patch_;
  const std::ptrdiff_t edge = felt.n;
  const std::size_t at = felt.at(leaf.lo.x - felt.lo.x, leaf.lo.y - felt.lo.y, leaf.lo.z - felt.lo.z);
  if (!approach(felt.distance.data() + at, edge * edge, edge, leaf.target, step)) return false;
  for_rows(felt, leaf.lo, [&](std::size_t row, std::size_t in_leaf) {
    std::copy_n(leaf.labels + in_leaf, kSide, felt.tissue.data() + row);
  });
  return true;
}

void IntermediateModel::drop(std::size_t i) noexcept {
  slot_of(moving_[i].lo) = 0;
  if (i + 1 < moving_.size()) {
    moving_[i] = moving_.back();
    slot_of(moving_[i].lo) = static_cast<std::uint32_t>(i + 1);
  }
  moving_.pop_back();
}

void IntermediateModel::constrain(const ContactInput& in, Contact& out) noexcept {
  since_update_ += in.dt;
  const bool same = settled();  // true: the models cutter_ and felt_ have the same tissue, so also the same proxy pose
  if (const double period = 1 / parameters_.update_rate; since_update_ >= period) {
    since_update_ = std::fmod(since_update_, period);
    hand_over();
  }
  animate(in);

  cutter_in_ = in;
  if (has_pose_ && !same) cutter_in_.X_WG = X_WC_;
  cutter_contact_ = {};
  cutter_.constrain(cutter_in_, cutter_contact_);
  X_WC_ = {cutter_contact_.p_WG, in.X_WT.R};
  has_pose_ = true;

  ContactInput felt_in = in;
  // No search for edges while the surface moves.
  felt_in.removal.cuts = in.removal.cuts || (!settled() && !felt_.fills());
  felt_in.removal.scrapes = felt_in.removal.must_earn = false;
  felt_in.removal.budget = felt_in.removal.specific_energy = 0;
  with_shank([&] { felt_.constrain(felt_in, out); });
  area_ = out.area;
  out.wall.share = cutter_contact_.wall.share;
  out.settled = out.settled && cutter_contact_.settled && settled();
}

bool IntermediateModel::cut(const ContactInput&, Contact& contact, Cut& cut, double& energy) noexcept {
  const bool changed = cutter_.cut(cutter_in_, cutter_contact_, cut, energy);
  contact.faults |= cutter_contact_.faults;
  if (cutter_contact_.gap.lost) contact.faults |= bits(Fault::kPatchEdge);
  return changed;
}

void IntermediateModel::feel(const ContactInput& in, Contact& contact, Felt& out) noexcept {
  with_shank([&] { felt_.feel(in, contact, out); });
}

}  // namespace typodont::haptics::offset
