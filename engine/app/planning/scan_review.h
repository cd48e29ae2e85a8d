// A scan before import: three sections, region, preview of labels, corrections with undo. No window or thread: the
// caller computes requested labels. Main thread. m, file frame F.
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

/// Number of sections of a scan: axial, coronal and sagittal.
inline constexpr std::size_t kScanSections = 3;
using ScanPlanes = std::array<SectionPlane, kScanSections>;

/// None, fewer samples, all voxels.
enum class LabelDetail { kNone, kCoarse, kFull };

/// A request for tissue labels. The caller computes them with ScanVolume::import(options).
struct LabelRequest {
  LabelDetail detail = LabelDetail::kNone;
  std::uint64_t revision = 0;  // of the region and preset
  haptics::ImportOptions options;
};

class ScanReview {
 public:
  explicit ScanReview(std::shared_ptr<const haptics::ScanVolume> scan);

  const std::shared_ptr<const haptics::ScanVolume>& scan() const { return scan_; }

  // All sections pass through the crosshair.
  const dvec3& crosshair() const { return crosshair_; }
  /// Or the nearest point inside.
  void look_at(const dvec3& p_F);
  /// Moves the crosshair by `slices` voxels perpendicular to the section.
  void scroll(std::size_t section, int slices);
  /// m, from 10 mm to the scan; a change centres the crosshair.
  double width() const { return width_; }
  double whole_width() const { return whole_; }
  void set_width(double width);
  ScanPlanes planes() const;
  /// R and L, or A and P; empty: unknown orientation.
  std::array<std::string_view, 2> sides(std::size_t section) const;

  // Functions for the region of the scan that will be imported.
  const haptics::ImportRegion& region() const { return region_; }
  /// Within the scan, at least 3 mm wide.
  void set_region(const haptics::ImportRegion& region);
  /// Faces of the region within `reach` (m) of p_F in this section: −1 lower, +1 upper, 0 none, per axis.
  glm::ivec3 walls_at(std::size_t section, const dvec3& p_F, double reach) const;
  void move_walls(const glm::ivec3& walls, const dvec3& p_F);
  /// Only coarse labels meanwhile.
  void set_dragging(bool dragging);

  // Functions for the tissue labels of the region.
  haptics::ImportPreset preset() const { return preset_; }
  void set_preset(haptics::ImportPreset preset);
  /// In the scan's voxels; requested automatically after dragging.
  void want_full() { full_wanted_ = true; }
  /// Coarse before full; empty: nothing missing.
  std::optional<LabelRequest> request() const;
  /// Labels of an earlier region count only if coarse and no current full ones exist. Corrections are repeated on full
  /// ones.
  void take(const LabelRequest& request, haptics::Imported labels);
  /// Coarse ones are not requested again for this region; full ones after want_full().
  void give_up(const LabelRequest& request);
  LabelDetail detail() const { return detail_; }
  /// Labels are of the present region and preset.
  bool current() const { return detail_ != LabelDetail::kNone && labels_revision_ == revision_; }
  /// Returns the tissue labels; null if none are computed yet.
  const haptics::Imported* labels() const { return detail_ == LabelDetail::kNone ? nullptr : &labels_; }
  const PerTissue& volumes() const { return volumes_; }  // returns the volume (m³) of each tissue
  /// Returns the options for importing the region with full tissue labels.
  haptics::ImportOptions options() const;

  // Need full labels of the present region.
  bool can_correct() const { return current() && detail_ == LabelDetail::kFull; }
  /// `joins`: undone together with the last one, as parts of a stroke.
  void correct(const haptics::Correction& correction, bool joins = false);
  bool can_undo() const { return can_correct() && done_ > 0; }
  bool can_redo() const { return can_correct() && done_ < steps_.size(); }
  void undo();
  void redo();
  /// On the same grid, such as with a scan's crowns. Can be undone; lost when labels are computed again.
  void replace(haptics::DenseTissue tissue);
  /// Not undone, in order; without replace().
  std::vector<haptics::Correction> corrections() const;

  /// Greys with label colours, darker outside the region. `pixels`: of the picture.
  render::Picture picture(const SectionPlane& plane, int pixels) const;
  /// Increases when picture() or planes() changes.
  std::uint64_t changes() const { return changes_; }

 private:
  struct Step {
    std::vector<haptics::Correction> corrections;
    std::vector<haptics::BoxContent> before;  // labels before the correction; after undo(), the labels after it
  };

  void apply(Step& step, const haptics::Correction& correction);
  void exchange(haptics::BoxContent& content);

  std::shared_ptr<const haptics::ScanVolume> scan_;
  dvec3 crosshair_, centre_;
  double whole_ = 0, width_ = 0;  // m: scan; shown part
  haptics::ImportRegion region_;
  haptics::ImportPreset preset_ = haptics::ImportPreset::kTooth;
  bool dragging_ = false, full_wanted_ = false;
  std::uint64_t revision_ = 1;  // number that increases whenever the region or the preset changes
  LabelDetail detail_ = LabelDetail::kNone, given_up_ = LabelDetail::kNone;
  std::uint64_t labels_revision_ = 0;
  haptics::Imported labels_;
  PerTissue volumes_{};
  std::vector<Step> steps_;
  std::size_t done_ = 0;  // number of correction steps that were not undone
  std::uint64_t changes_ = 0;
};

/// sRGB 0..255.
glm::dvec3 label_color(Tissue tissue);

}  // namespace typodont
