// Reads scans: NRRD with teem, NIfTI with nifti_clib, MetaImage with zlib, DICOM with GDCM. If the content is invalid,
// an Error states file, position, found and expected value. Before memory is allocated, sizes are compared with the
// size of the file.
#pragma once

#include <array>
#include <filesystem>
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
  std::array<glm::dvec3, 3> step{};  // mm, vector from one voxel to the next along each axis; it may be oblique
  bool has_spacing = false;          // true if the file states a spacing
  bool has_unit = false;             // true if the file states the unit of its spacing
  std::string spacing_place;         // where the file states the spacing, for messages
  std::string space;                 // coordinate space: "LPS", "RAS" or empty (unknown)
  std::vector<std::string> notes;    // notes for the user
  glm::dvec3 origin{0};              // mm, position of the first voxel
};

/// A scan whose axes run nearly along the axes of the scan's own space. To get such a scan, the axes of the file were
/// exchanged and reversed, but the scan was never mirrored. An oblique scan keeps its own axes: a point p of the scan
/// (m) has the position world_rotation · p in the space.
struct Scan {
  std::string format;
  Grid<float> grey;
  glm::dvec3 spacing{0};  // m, distance between voxels along each axis
  glm::dvec3 origin{0};   // m, position of voxel (0,0,0)
  std::string space;      // coordinate space: "LPS", "RAS" or empty (unknown)
  glm::dmat3 world_rotation{1};
  std::vector<std::string> notes;
};

/// The arguments of a function that reads a scan.
struct ScanRequest {
  std::filesystem::path file;    // a file or a folder
  std::optional<int> series;     // for DICOM: number of the series in the printed list
  std::optional<double> memory;  // bytes, largest memory that reading may use; if not given, the free memory
};

/// A file format of scans. To add a format, write a file NAME.cpp that defines `const ScanFormat NAME_format`, and add
/// a row to the table in scan.cpp.
struct ScanFormat {
  std::string name;                             // for example "NRRD"
  std::vector<std::string> endings;             // extensions shown to users, lower case: ".nrrd"
  std::vector<std::string> further_extensions;  // other extensions that are accepted, too
  /// Returns true if a file that begins with these bytes has this format; the name of the file does not matter. If
  /// `begins` is null, the file's extension decides.
  bool (*begins)(std::string_view first_bytes);
  RawScan (*read)(const ScanRequest& request);  // throws Error
};
const std::vector<ScanFormat>& scan_formats();

/// Smallest and largest voxel edge, in m, that a scan may have. With larger voxels, the tissues cannot be
/// distinguished.
struct SpacingLimits {
  double smallest, largest;
  std::string_view of;  // body to which the limits apply, for messages: "a tooth"
  // advice for the error message if the voxels are too coarse; begins with "; "; may be empty
  std::string_view instead;
};

/// Reads a scan. `spacing` (m, along the file's own axes) replaces the spacing of the file. `nan_grey` replaces voxels
/// that are NaN.
Scan read_scan(const ScanRequest& request, const std::optional<glm::dvec3>& spacing,
               const std::optional<double>& nan_grey, const SpacingLimits& limits);

/// Corrects a scan whose third axis is not perpendicular to the other two axes, because the gantry was tilted. Each
/// slice is shifted within its plane, by cubic interpolation. The first two axes must be perpendicular to each other.
/// Returns the angle, in rad, by which the third axis was corrected.
double undo_shear(const std::filesystem::path& file, RawScan& raw);

// Largest number of voxels of a scan. This limit and the functions below are used by the readers of several formats.
inline constexpr double kMostVoxels = 1.0e9;

/// Converts the numbers in a buffer to grey values. With `swap`, the bytes of each number are reversed.
std::vector<float> decode(const std::vector<char>& bytes, std::size_t count, Element type, bool swap);

/// Throws Error unless each size is at least 4, the product of the sizes is at most kMostVoxels, and so many voxels can
/// be read with at most `memory` bytes (if not given: with the free memory).
void check_sizes(const std::filesystem::path& file, std::string_view place, const std::vector<long long>& sizes,
                 const std::optional<double>& memory = std::nullopt);
std::uintmax_t size_of_file(const std::filesystem::path& file);  // throws Error if the file cannot be read
/// Reads all numbers of a text such as "1 2.5 -3". Returns no value if the text contains anything else or a number that
/// is not finite.
std::optional<std::vector<double>> parse_numbers(std::string_view text);
/// Millimetres per unit of length: "mm", "um", "cm", "m" or a spelling of their names. No value for another text.
std::optional<double> millimetres_per(std::string unit);
/// Returns the first bytes as text for a message.
std::string excerpt(std::string_view bytes);

}  // namespace typodont::haptics::importing
