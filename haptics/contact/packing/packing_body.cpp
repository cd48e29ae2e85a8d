#include "haptics/contact/packing/packing_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::packing {

namespace {

constexpr int kBlock = 8;  // voxels, edge length of the blocks in which the distance field is updated
// Voxels. Whenever the ball that cuts a sphere has moved this far, the ball's position and radius are stored as a note.
// rasterize() updates the distance field from the notes.
constexpr double kNoteEvery = 0.03;
// voxels; interpolation changes the distance field up to this far beyond the cut sphere and the gaps around it
constexpr double kAround = 1.8;
// In radii of the packing's largest hole: distance up to which a cut sphere also empties the gaps around it.
constexpr double kGapsAround = 2;
// largest number of stored notes (positions of cutting balls); with more, the field is updated and they are deleted
constexpr std::size_t kMost = 50000;

const dvec3 kNowhere(std::numeric_limits<double>::infinity());

/// Position of the cutting ball when it overlapped `s` most deeply.
dvec3 ball_of(const CutSphere& s) {
  return s.base - (s.tool + s.base_radius - s.overlap) * s.away;
}

/// State of a sphere after a ball of radius `r` at its centre has removed it completely.
CutSphere taken_by_ball(const CutSphere& s, double r) {
  CutSphere gone = s;
  gone.base = s.center(), gone.base_radius = s.radius(), gone.away = dvec3(0, 0, 1);
  gone.tool = r;
  gone.overlap = gone.tool + gone.base_radius;
  gone.volume = 0;
  return gone;
}

const SpherePacking& checked(const SpherePacking& packing, const TissueVolume& volume, const Parameters& parameters) {
  if (const std::uint64_t hash = volume.hash(); packing.tissue_hash != hash) {
    throw Error(parameters.file.string(), "tissue_hash", fmt::format("{:016x}", packing.tissue_hash),
                fmt::format("{:016x}, the tissue of this scene", hash));
  }
  return packing;
}

}  // namespace

PackingBody::PackingBody(TissueVolume tissue, const SpherePacking& packing, std::span<const Tool> tools,
                         const Parameters& parameters)
    : volume_(std::move(tissue)),
      packing_(checked(packing, volume_, parameters)),
      spheres_(packing, parameters.removal, cell_volumes(packing, SphereTree(packing.center, packing.radius), volume_)),
      parameters_(parameters),
      buffers_(packing.size()),
      loose_(packing, spheres_.tree()),
      kept_in_(packing.size(), 0),
      changed_in_(packing.size(), 0),
      last_noted_(packing.size(), kNowhere),
      paints_(volume_.paints()) {
  for (std::size_t t = 0; t < tools.size(); ++t) tools_.push_back(spheres_of(tools, t, parameters_));
  read_materials();
}

/// Sets tissue and hardness of each sphere from the voxel at its initial centre, but only if the voxel was painted
/// after packing: the packer smooths borders, so a voxel's label there may differ from its sphere's tissue.
void PackingBody::read_materials() {
  const VoxelFrame& frame = volume_.frame();
  const bool first = label_.empty();
  label_.resize(packing_.size());
  for (std::size_t i = 0; i < packing_.size(); ++i) {
    float distance;
    Tissue label;
    std::uint8_t hardness = kOwnHardness;
    volume_.copy(glm::ivec3(glm::round(frame.to_voxels(packing_.center[i]))), glm::ivec3(1), &distance, &label,
                 &hardness);
    if (first) label_[i] = label;
    const double fitted = parameters_.fitted.empty() ? 1.0 : static_cast<double>(parameters_.fitted[i]);
    const bool painted = label != label_[i] && label != Tissue::kAir;
    spheres_.set_material(static_cast<int>(i), painted ? label : packing_.tissue[i],
                          fitted * hardness_fraction(hardness));
  }
}

void PackingBody::take_over_paint() {
  if (volume_.paints() == paints_) return;
  paints_ = volume_.paints();
  end_stroke();
  read_materials();
  repainted_ = true;
  // Adds the user's new brush strokes to the list for undo().
  for (std::size_t known = strokes_in_field(); known < volume_.strokes().done; ++known) {
    done_.push_back({{}, true});
    undone_.clear();
  }
}

std::size_t PackingBody::strokes_in_field() const {
  return static_cast<std::size_t>(
      std::count_if(done_.begin(), done_.end(), [](const Stroke& stroke) { return stroke.in_field; }));
}

/// Records a change of a sphere, for undo, for snapshots and for the update of the field.
void PackingBody::changed(int i, const CutSphere& before) {
  const auto k = static_cast<std::size_t>(i);
  if (in_stroke_ && kept_in_[k] != stroke_) {
    kept_in_[k] = stroke_;
    done_.back().kept.push_back({i, before, last_noted_[k]});
  }
  if (remembers_) written_.push_back(i);
  const CutSphere& now = spheres_.sphere(i);
  // A cut from another side begins: stores the end of the previous cut as a note, for the update of the field.
  if (before.overlap > 0 && now.base != before.base && ball_of(before) != last_noted_[k]) note(i, before);
  const double moved = glm::distance(ball_of(now), last_noted_[k]);
  if (!(moved < kNoteEvery * volume_.frame().voxel) || !(spheres_.tree().radius(i) > 0)) note(i, now);
}

void PackingBody::note(int i, const CutSphere& state) {
  last_noted_[static_cast<std::size_t>(i)] = ball_of(state);
  notes_.push_back({i, ball_of(state), state.tool});
  if (notes_.size() > kMost) rasterize();
}

void PackingBody::carve(const Cut& cut, bool) {
  take_over_paint();
  cut_now_.clear();
  ++cut_number_;
  packing::carve(spheres_, tools_[cut.tool], cut.X_WA, cut.X_WB, buffers_, [&](Place place, const CutSphere& before) {
    const int i = spheres_.tree().sphere_in(place);
    changed(i, before);
    if (std::exchange(changed_in_[static_cast<std::size_t>(i)], cut_number_) == cut_number_) return;
    cut_now_.push_back({i, before.center(), before.radius()});
  });
  take_out_pieces(cut);
}

void PackingBody::take_out_pieces(const Cut& cut) {
  for (const std::vector<int>& piece : loose_.after_cut(spheres_, cut_now_)) {
    LoosePiece loose{cut.index, cut.t, {}, 0, {}};
    dvec3 lo(1e300), hi(-1e300);
    std::vector<CutSphere> before;
    for (const int i : piece) {
      before.push_back(spheres_.sphere(i));
      const dvec3 c = before.back().center();
      const double r = spheres_.tree().radius(i);
      lo = glm::min(lo, c - r), hi = glm::max(hi, c + r);
      loose.removed[static_cast<std::size_t>(spheres_.tissue(i))] += spheres_.volume(i);
      spheres_.set(i, taken_by_ball(before.back(), r));
    }
    // Also removes the gaps around a loose sphere, up to the spheres that stay. If an earlier cut has reduced the
    // sphere's radius, the range of these gaps is reduced in proportion.
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const dvec3 c = before[k].center();
      const double r = before[k].radius(), whole = packing_.radius[static_cast<std::size_t>(piece[k])];
      const double clearance = spheres_.tree().clearance(c, r + r / whole * kGapsAround * packing_.max_hole);
      spheres_.set(piece[k], taken_by_ball(before[k], std::max(r, clearance)));
      changed(piece[k], before[k]);
    }
    loose.center_W = (lo + hi) / 2.0;
    const dvec3 edges = hi - lo;
    loose.radius = std::max({edges.x, edges.y, edges.z}) / 2;
    pieces_.push_back(loose);
  }
}

void PackingBody::begin_stroke() {
  take_over_paint();
  end_stroke();
  done_.emplace_back();
  undone_.clear();
  volume_.begin_stroke();
  ++stroke_;
  in_stroke_ = true;
}

void PackingBody::end_stroke() {
  if (!in_stroke_) return;
  in_stroke_ = false;
  rasterize();
  volume_.end_stroke();
  done_.back().in_field = volume_.strokes().done > strokes_in_field();
  if (done_.back().kept.empty() && !done_.back().in_field) done_.pop_back();
}

/// Exchanges the current states of the spheres that a stroke changed with the stored states, for undo and redo.
void PackingBody::exchange(Stroke& stroke) {
  for (Kept& kept : stroke.kept) {
    const auto k = static_cast<std::size_t>(kept.sphere);
    double& back = taken_back_[static_cast<std::size_t>(spheres_.tissue(kept.sphere))];
    back -= spheres_.volume(kept.sphere);
    const CutSphere now = spheres_.sphere(kept.sphere);
    spheres_.set(kept.sphere, kept.state);
    kept.state = now;
    back += spheres_.volume(kept.sphere);
    std::swap(kept.last_noted, last_noted_[k]);
    if (remembers_) written_.push_back(kept.sphere);
  }
}

/// Reads tissue and hardness of all spheres again after undo or redo, because the stroke may contain painting.
void PackingBody::take_back_paint() {
  if (paints_ == 0) return;
  read_materials();
  repainted_ = true;
}

bool PackingBody::undo() {
  take_over_paint();
  return move_last(done_, undone_, [&](Stroke& stroke) {
    exchange(stroke);
    if (stroke.in_field) volume_.undo(), take_back_paint();
  });
}

bool PackingBody::redo() {
  take_over_paint();
  return move_last(undone_, done_, [&](Stroke& stroke) {
    exchange(stroke);
    if (stroke.in_field) volume_.redo(), take_back_paint();
  });
}

std::unique_ptr<Snapshot> PackingBody::make_snapshot() const {
  auto snapshot = std::make_unique<PackingSnapshot>();
  snapshot->spheres = spheres_;
  return snapshot;
}

void PackingBody::cut_out(Snapshot& snapshot, std::uint32_t /*held*/) {
  take_over_paint();
  static_cast<PackingSnapshot&>(snapshot).spheres = spheres_;
  repainted_ = false;
}

void PackingBody::remember_writes(bool wanted) {
  remembers_ = wanted;
  written_.clear();
}

void PackingBody::bring_up_to_date(Snapshot& snapshot) {
  SphereTissue& copy = static_cast<PackingSnapshot&>(snapshot).spheres;
  if (repainted_) {
    copy = spheres_;
    repainted_ = false;
  }
  for (const int i : written_) copy.set(i, spheres_.sphere(i));
  written_.clear();
}

TissueVolume& PackingBody::rasterize() {
  if (notes_.empty()) return volume_;
  const VoxelFrame& frame = volume_.frame();
  const auto box = [&](const Note& note) {
    const auto k = static_cast<std::size_t>(note.sphere);
    const double reach = (packing_.radius[k] + kGapsAround * packing_.max_hole) / frame.voxel + kAround;
    const dvec3 p_V = frame.to_voxels(packing_.center[k]);
    return std::pair{glm::ivec3(glm::ceil(p_V - reach)), glm::ivec3(glm::floor(p_V + reach))};
  };
  // Sorts the notes (removed parts of spheres) by the blocks of the distance field that they affect.
  std::map<glm::ivec3, std::vector<std::size_t>, LessByAxes> blocks;
  const auto block_of = [](const glm::ivec3& v) { return glm::ivec3(glm::floor(dvec3(v) / double{kBlock})); };
  for (std::size_t n = 0; n < notes_.size(); ++n) {
    const auto [lo, hi] = box(notes_[n]);
    const glm::ivec3 first = block_of(lo), last = block_of(hi);
    for_each_voxel_between(first, last, [&](int x, int y, int z) { blocks[{x, y, z}].push_back(n); });
  }
  RasterBlock block{{}, glm::ivec3(kBlock), std::vector<float>(kBlock * kBlock * kBlock)};
  for (const auto& [at, numbers] : blocks) {
    block.lo = kBlock * at;
    volume_.copy(block.lo, block.size, block.distance.data(), nullptr);
    bool raised = false;
    for (const std::size_t n : numbers) {
      const Note& note = notes_[n];
      const auto [box_lo, box_hi] = box(note);
      const glm::ivec3 lo = glm::max(box_lo, block.lo) - block.lo,
                       hi = glm::min(box_hi, block.lo + kBlock - 1) - block.lo;
      const glm::vec3 from(frame.to_voxels(note.p_W) - dvec3(block.lo));
      const auto r = static_cast<float>(note.r / frame.voxel);
      for (int x = lo.x; x <= hi.x; ++x) {
        for (int y = lo.y; y <= hi.y; ++y) {
          float* row = block.distance.data() + (x * kBlock + y) * kBlock;
          for (int z = lo.z; z <= hi.z; ++z) {
            const float depth = r - glm::distance(glm::vec3(x, y, z), from);
            if (depth > row[z]) row[z] = depth, raised = true;
          }
        }
      }
    }
    if (raised) volume_.replace(block);
  }
  notes_.clear();
  return volume_;
}

}  // namespace typodont::haptics::packing
