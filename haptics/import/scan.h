// Reads scans: NRRD (teem), NIfTI (nifti_clib), MetaImage (zlib), DICOM (GDCM). Every Error has file, position, found
// and expected value. Sizes are checked before memory is allocated.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/import/grid.h"
#include "haptics/import/scan_element.h"

namespace typodont::haptics::importing {

/// The content of a scan file before any processing.
struct RawScan {
  std::string format;  // name of the format: "NRRD" …
  glm::ivec3 size{0};
  std::vector<float> grey;           // grey values; the file's first axis is the fastest index
  std::array<glm::dvec3, 3> step{};  // mm, step between voxels along each axis; may be oblique
  bool has_spacing = false;          // true if the file states a spacing
  bool has_unit = false;             // true if the file states the unit of its spacing
  std::string spacing_place;         // where the file states the spacing, for messages
  std::string space;                 // coordinate space: "LPS", "RAS" or empty (unknown)
  std::vector<std::string> notes;    // notes for the user
  glm::dvec3 origin{0};              // mm, position of the first voxel
  // Names of the values of a label map, as far as the file states them; nullopt: the values are grey values.
  std::optional<std::map<int, std::string>> labels;
};

/// A scan with right-handed axes x, y, z. If the scan was taken obliquely, a position p (m) in the scan is at
/// world_rotation · p in the scanner's coordinates.
struct Scan {
  std::string format;
  Grid<float> grey;
  glm::dvec3 spacing{0};  // m, distance between voxels along each axis
  glm::dvec3 origin{0};   // m, position of voxel (0,0,0)
  std::string space;      // coordinate space: "LPS", "RAS" or empty (unknown)
  glm::dmat3 world_rotation{1};
  std::vector<std::string> notes;
  std::optional<std::map<int, std::string>> labels;  // as RawScan::labels
};

/// The arguments of a function that reads a scan.
struct ScanRequest {
  std::filesystem::path file;    // a file or a folder
  std::optional<int> series;     // for DICOM: number of the series in the printed list
  std::optional<double> memory;  // bytes, largest allowed memory; empty: the free memory
};

/// A scan format. For a new one, write NAME.cpp with `const ScanFormat NAME_format`, and add it to the list in
/// scan.cpp.
struct ScanFormat {
  std::string name;                             // for example "NRRD"
  std::vector<std::string> endings;             // extensions shown to users, lower case: ".nrrd"
  std::vector<std::string> further_extensions;  // other extensions that are accepted, too
  /// Recognises the format by the file's first bytes; null: it is recognised by its extension.
  bool (*begins)(std::string_view first_bytes);
  RawScan (*read)(const ScanRequest& request);  // throws Error
};
const std::vector<ScanFormat>& scan_formats();

/// Limits of the distance between voxels, m.
struct SpacingLimits {
  double smallest, largest;
  std::string_view of;  // body to which the limits apply, for messages: "a tooth"
  // Advice in the message about too coarse voxels; begins with "; "; may be empty.
  std::string_view instead;
};

/// `spacing` (m, along the file's axes) replaces the spacing in the file; `nan_grey` replaces NaN voxels.
Scan read_scan(const ScanRequest& request, const std::optional<glm::dvec3>& spacing,
               const std::optional<double>& nan_grey, const SpacingLimits& limits);

/// Corrects a tilted gantry: shifts each slice in its plane (cubic interpolation). The first two axes must be
/// perpendicular. Returns the tilt, rad.
double undo_shear(const std::filesystem::path& file, RawScan& raw);

// Largest number of voxels of a scan.
inline constexpr double kMaxVoxels = 1.0e9;

/// Replaces steps that are zero or not finite by 1 mm, so that has_spacing is false, and origins that are not finite by
/// 0.
void replace_impossible_steps(RawScan& scan);

/// Converts bytes to numbers. `swap`: reverses the byte order.
std::vector<float> decode(const std::vector<char>& bytes, std::size_t count, Element type, bool swap);

/// Throws Error unless each size is at least 4, their product at most kMaxVoxels, and `memory` bytes suffice (empty:
/// the free memory).
void check_sizes(const std::filesystem::path& file, std::string_view place, const std::vector<long long>& sizes,
                 const std::optional<double>& memory = std::nullopt);
std::uintmax_t size_of_file(const std::filesystem::path& file);  // throws Error if the file cannot be read
/// The first bytes of a file, at most 512.
std::string first_bytes(const std::filesystem::path& file);
/// Reads to the end of the line, but at most `longest` bytes. Returns the last byte read, or EOF.
int read_line(std::istream& in, std::string& line, std::size_t longest);
/// Reads a text such as "1 2.5 -3"; nullopt if it contains anything but numbers.
std::optional<std::vector<double>> parse_numbers(std::string_view text);
/// Millimetres in a unit "mm", "um", "cm", "m" or another spelling of these; nullopt for other units.
std::optional<double> millimetres_per(std::string unit);
/// Returns the first bytes as text for a message.
std::string excerpt(std::string_view bytes);

}  // namespace typodont::haptics::importing
