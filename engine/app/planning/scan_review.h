// A scan that a user examines before its import: three sections with a crosshair, the region that is imported, its
// labels as a preview, and corrections of the labels with undo. This class has no window and no thread; the caller
// computes the labels that it requests. Main thread only. Positions are in m, in the coordinates of the scan's file
// (frame F).
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

/// Accuracy of the region's tissue labels: not computed, computed for fewer samples, computed for all voxels.
enum class LabelDetail { kNone, kCoarse, kFull };

/// A request for tissue labels. The caller computes them with ScanVolume::import(options).
struct LabelRequest {
  LabelDetail detail = LabelDetail::kNone;
  std::uint64_t revision = 0;  // revision number of the region and preset to which the tissue labels belong
  haptics::ImportOptions options;
};

class ScanReview {
 public:
  explicit ScanReview(std::shared_ptr<const haptics::ScanVolume> scan);

  const std::shared_ptr<const haptics::ScanVolume>& scan() const { return scan_; }

  // Functions for the shown sections. The crosshair is the point through which all three sections pass.
  const dvec3& crosshair() const { return crosshair_; }
  /// Moves the crosshair to the point. If the point is outside the scan, moves it to the nearest point inside.
  void look_at(const dvec3& p_F);
  /// Moves the crosshair by `slices` voxels perpendicular to the section.
  void scroll(std::size_t section, int slices);
  /// Returns the width of the shown part of each section, m: from 10 mm to the size of the whole scan. After a change,
  /// the crosshair is in the middle of each section.
  double width() const { return width_; }
  double whole_width() const { return whole_; }
  void set_width(double width);
  ScanPlanes planes() const;
  /// Returns the letters at the left and right edge of a section, which name the patient's sides: R and L, or A and P
  /// (front, back). Empty if the scan does not state the orientation of its coordinates.
  std::array<std::string_view, 2> sides(std::size_t section) const;

  // Functions for the region of the scan that will be imported.
  const haptics::ImportRegion& region() const { return region_; }
  /// Sets the region. It is limited to the scan, and is at least 3 mm wide.
  void set_region(const haptics::ImportRegion& region);
  /// Finds the faces of the region's box that the user can drag at the point p_F of this section. In the section, a
  /// face is seen as a line; its distance from the point must be at most `reach` (m). Returns for each axis −1 for the
  /// lower face, +1 for the upper face, 0 for none.
  glm::ivec3 walls_at(std::size_t section, const dvec3& p_F, double reach) const;
  void move_walls(const glm::ivec3& walls, const dvec3& p_F);
  /// Set to true while the user drags a face of the region. During this time, only coarse tissue labels are requested.
  void set_dragging(bool dragging);

  // Functions for the tissue labels of the region.
  haptics::ImportPreset preset() const { return preset_; }
  void set_preset(haptics::ImportPreset preset);
  /// Requests full tissue labels, with the scan's own voxel size. After the user has dragged a face of the region, full
  /// labels are requested automatically.
  void want_full() { full_wanted_ = true; }
  /// Returns the tissue labels that should be computed next, if any are missing. Coarse labels come before full labels.
  std::optional<LabelRequest> request() const;
  /// Receives the tissue labels of a request. Labels that belong to an earlier region are used only if they are coarse
  /// and there are no full labels of the present region. The corrections are applied again to full labels.
  void take(const LabelRequest& request, haptics::Imported labels);
  /// Reports that the computation of a request failed or was cancelled. Coarse tissue labels are then not requested
  /// again for the present region, and full labels only after another call of want_full().
  void give_up(const LabelRequest& request);
  LabelDetail detail() const { return detail_; }
  /// Returns true if the tissue labels belong to the present region and preset.
  bool current() const { return detail_ != LabelDetail::kNone && labels_revision_ == revision_; }
  /// Returns the tissue labels; null if none are computed yet.
  const haptics::Imported* labels() const { return detail_ == LabelDetail::kNone ? nullptr : &labels_; }
  const PerTissue& volumes() const { return volumes_; }  // returns the volume (m³) of each tissue
  /// Returns the options for importing the region with full tissue labels.
  haptics::ImportOptions options() const;

  // Functions for corrections. A correction requires full tissue labels of the present region.
  bool can_correct() const { return current() && detail_ == LabelDetail::kFull; }
  /// Applies a correction. `joins`: true if this correction continues the last one (as the next segment of a brush
  /// stroke does); undo() then undoes both together.
  void correct(const haptics::Correction& correction, bool joins = false);
  bool can_undo() const { return can_correct() && done_ > 0; }
  bool can_redo() const { return can_correct() && done_ < steps_.size(); }
  void undo();
  void redo();
  /// Replaces the tissue by tissue on the same sample grid, for example with the crowns of an intraoral scan. This can
  /// be undone like a correction. When the labels are computed again, the replacement is lost.
  void replace(haptics::DenseTissue tissue);
  /// Returns the corrections that were not undone, in order. A replacement of the tissue by replace() is not included.
  std::vector<haptics::Correction> corrections() const;

  /// Draws a section: the grey values with the colours of the tissue labels, darker outside the region. `pixels`: width
  /// and height of the picture.
  render::Picture picture(const SectionPlane& plane, int pixels) const;
  /// Returns a number that increases whenever the result of picture() or planes() changes.
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
  double whole_ = 0, width_ = 0;  // m, width of the whole scan, and width of the part that a section shows
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

/// Returns the colour in which the label of a tissue is drawn over the grey values, sRGB 0..255.
glm::dvec3 label_color(Tissue tissue);

}  // namespace typodont
