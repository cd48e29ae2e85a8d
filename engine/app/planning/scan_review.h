// A scan before its import: three sections with a crosshair, the region that is imported, its labels as a preview, and
// corrections of the labels with undo. Has no window and no thread; the caller computes the labels that it requests.
// Main thread. Positions are in m, in the scan file's coordinates (frame F).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/app/planning/implant_planner.h"
#include "engine/render/picture.h"
#include "haptics/import/corrections.h"
#include "haptics/import/scan_volume.h"

namespace typodont {

/// Sections of a scan: axial, coronal and sagittal.
inline constexpr std::size_t kScanSections = 3;
using ScanPlanes = std::array<SectionPlane, kScanSections>;

/// How exactly the labels of the region are known.
enum class LabelDetail { kNone, kCoarse, kFull };

/// Labels that should be computed: ScanVolume::import(options).
struct LabelRequest {
  LabelDetail detail = LabelDetail::kNone;
  std::uint64_t revision = 0;  // state of region and preset to which the labels belong
  haptics::ImportOptions options;
};

class ScanReview {
 public:
  explicit ScanReview(std::shared_ptr<const haptics::ScanVolume> scan);

  const std::shared_ptr<const haptics::ScanVolume>& scan() const { return scan_; }

  // The view.
  const dvec3& crosshair() const { return crosshair_; }
  void look_at(const dvec3& p_F);  // moves the crosshair; a point outside the scan becomes the nearest inside
  /// Moves the crosshair by `slices` voxels along the section's normal.
  void scroll(std::size_t section, int slices);
  /// Width of each section, m: from 10 mm to the whole scan. A changed width centres the sections at the crosshair.
  double width() const { return width_; }
  double whole_width() const { return whole_; }
  void set_width(double width);
  ScanPlanes planes() const;
  /// The letters of the patient's sides at the left and at the right edge of a section: R and L, A and P; empty if the
  /// scan does not state its coordinates.
  std::array<std::string_view, 2> sides(std::size_t section) const;

  // The region.
  const haptics::ImportRegion& region() const { return region_; }
  void set_region(const haptics::ImportRegion& region);  // is limited to the scan and to a size of at least 3 mm
  /// The walls of the region whose edges are within `reach` (m) of p in this section: −1 the lower, +1 the upper wall
  /// of each axis, 0 none.
  glm::ivec3 walls_at(std::size_t section, const dvec3& p_F, double reach) const;
  void move_walls(const glm::ivec3& walls, const dvec3& p_F);
  /// True while the user drags a wall; until it ends, only coarse labels are requested.
  void set_dragging(bool dragging);

  // The labels.
  haptics::ImportPreset preset() const { return preset_; }
  void set_preset(haptics::ImportPreset preset);
  /// Requests labels at the scan's own voxel size. After a drag this happens by itself.
  void want_full() { full_wanted_ = true; }
  /// The labels that are missing and should be computed next; coarse ones first.
  std::optional<LabelRequest> request() const;
  /// Shows the labels of a request. Labels of an earlier region replace only coarse ones. The corrections are applied
  /// to full labels again.
  void take(const LabelRequest& request, haptics::Imported labels);
  /// The computation of a request failed or was cancelled, and is not requested again for this region.
  void give_up(const LabelRequest& request);
  LabelDetail detail() const { return detail_; }
  /// True if the labels are those of the present region.
  bool current() const { return detail_ != LabelDetail::kNone && labels_revision_ == revision_; }
  /// Null: there are no labels yet.
  const haptics::Imported* labels() const { return detail_ == LabelDetail::kNone ? nullptr : &labels_; }
  const PerTissue& volumes() const { return volumes_; }  // m³
  /// Options of an import of the region with full labels.
  haptics::ImportOptions options() const;

  // Corrections; they need full labels of the present region.
  bool can_correct() const { return current() && detail_ == LabelDetail::kFull; }
  /// Applies a correction. `joins`: it belongs to the latest one and is undone with it, as a stroke's segments do.
  void correct(const haptics::Correction& correction, bool joins = false);
  bool can_undo() const { return can_correct() && done_ > 0; }
  bool can_redo() const { return can_correct() && done_ < steps_.size(); }
  void undo();
  void redo();
  /// Replaces the tissue by one with the same samples, for example with the crowns of an intraoral scan. It is undone
  /// like a correction, but is lost with the present labels.
  void replace(haptics::DenseTissue tissue);
  /// The corrections that are in effect, in order; without replaced tissue.
  std::vector<haptics::Correction> corrections() const;

  /// Draws a section: grey values, the labels as a colour over them, darker outside the region. `pixels`: width and
  /// height.
  render::Picture picture(const SectionPlane& plane, int pixels) const;
  /// A number that changes with everything that picture() and planes() show.
  std::uint64_t changes() const { return changes_; }

 private:
  struct Step {
    std::vector<haptics::Correction> corrections;
    std::vector<haptics::BoxContent> before;  // after undo(): the content afterwards
  };

  void apply(Step& step, const haptics::Correction& correction);
  void exchange(haptics::BoxContent& content);

  std::shared_ptr<const haptics::ScanVolume> scan_;
  dvec3 crosshair_, centre_;
  double whole_ = 0, width_ = 0;  // m
  haptics::ImportRegion region_;
  haptics::ImportPreset preset_ = haptics::ImportPreset::kTooth;
  bool dragging_ = false, full_wanted_ = false;
  std::uint64_t revision_ = 1;  // of region and preset
  LabelDetail detail_ = LabelDetail::kNone, given_up_ = LabelDetail::kNone;
  std::uint64_t labels_revision_ = 0;
  haptics::Imported labels_;
  PerTissue volumes_{};
  std::vector<Step> steps_;
  std::size_t done_ = 0;  // number of steps in effect; the others were undone
  std::uint64_t changes_ = 0;
};

/// Colour of a tissue's label over the grey values, sRGB 0..255.
glm::dvec3 label_color(Tissue tissue);

}  // namespace typodont
