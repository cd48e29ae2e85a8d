// Several intraoral scans of one mouth (upper jaw, lower jaw, bite) as one tissue. Frame W is the frame of the first
// scan, frame K that of another scan, and frame B that of the bite scan. Not for the servo thread. Throws Error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

struct MouthFiles {
  std::vector<std::filesystem::path> scans;   // the first scan is the one that is drilled
  std::optional<std::filesystem::path> bite;  // surface that shows teeth of all scans while the jaws are closed
  // m, opening of the mouth: the scans of the opposite jaw are moved away from the first scan by this distance, so that
  // an instrument fits between the jaws
  double open = 0;
};

/// Registration of the bite scan to one of the scans.
struct BiteFit {
  double median = 0, most_of = 0;  // m: 50 % and 95 % quantile of the distances between the two surfaces
  double predicted_error = 0;      // m, rms error at the agreeing points, as the covariance predicts it
  double area = 0;                 // m², area of the bite scan that agrees with the scan
};

struct MouthScan {
  Pose X_WK;
  double moved = 0;            // m, displacement of this scan's middle by the bite registration
  std::optional<BiteFit> fit;  // registration of the bite scan to this scan; empty if there is no bite scan
};

struct ImportedMouth {
  haptics::Imported imported;
  std::vector<MouthScan> scans;
  // unit vector in frame W, from the border of the first scan to this scan's teeth; zero if the direction is unknown
  dvec3 up{0};
  dvec3 top{0};  // m, the highest point of the first scan along `up`, in frame W
};

/// Imports the scans with `options` and joins them in one volume. Without a bite scan, the files share one frame. With
/// a bite scan, the frames of all files must agree within about 2 mm; the bite scan is registered to every scan, which
/// gives the poses of all scans relative to the first one. A scan whose registration cannot be trusted is refused.
/// `options.preset` must be kArch if there is a bite scan or an opening.
ImportedMouth import_mouth(const MouthFiles& files, const haptics::ImportOptions& options);

/// Returns the files of a mouth for meshes whose roles the user has not stated: a file whose name contains "bite" is
/// the bite scan. Throws Error if there are several such files.
MouthFiles mouth_files(const std::vector<std::filesystem::path>& meshes);

}  // namespace typodont
