// Reading scans: NRRD through teem, NIfTI through nifti_clib, MetaImage with zlib. Any garbage gives an Error that
// names the file, the place in it, what was found and what was expected; sizes are checked against the files before
// memory is taken.
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

/// What a file says, before anything is made of it.
struct RawScan {
  std::string format;  // "NRRD" …
  glm::ivec3 size{0};
  std::vector<float> grey;           // the file's first axis runs fastest
  std::array<glm::dvec3, 3> step{};  // from one voxel to the next along each axis, mm; directions may be oblique
  bool has_spacing = false;          // the file states one
  bool has_unit = false;             // … and its unit
  std::string spacing_place;         // where it states it, for messages
  std::string space;                 // "LPS", "RAS" or empty: not known
  std::vector<std::string> notes;    // what a user should know
  glm::dvec3 origin{0};              // of the first voxel, mm
};

/// A scan with axes turned (by quarter turns and flips, never a mirror image) along those of its own space. A place p
/// of it, in m, is world_rotation · p there: an oblique scan keeps its own axes.
struct Scan {
  std::string format;
  Grid<float> grey;
  glm::dvec3 spacing{0};  // m
  glm::dvec3 origin{0};   // m, of voxel (0,0,0)
  std::string space;      // see RawScan
  glm::dmat3 world_rotation{1};
  std::vector<std::string> notes;
};

/// What is to be read.
struct ScanRequest {
  std::filesystem::path file;  // or a folder
  std::optional<int> series;   // DICOM: which one, as the list of them says
};

/// A format that scans come in. A new one is a file NAME.cpp that defines `const ScanFormat NAME_format`, and a row in
/// the table of scan.cpp.
struct ScanFormat {
  std::string name;                      // "NRRD"
  std::vector<std::string> endings;      // of its files, lower case, as users are told: ".nrrd"
  std::vector<std::string> odd_endings;  // read too, but not offered
  /// Whether a file that begins with these bytes is one, whatever its name. Null: only the name tells.
  bool (*begins)(std::string_view first_bytes);
  RawScan (*read)(const ScanRequest& request);  // throws Error
};
const std::vector<ScanFormat>& scan_formats();

/// Smallest and largest voxel, m, that tissue can be told in.
struct SpacingLimits {
  double smallest, largest;
  std::string_view of;       // "a tooth"
  std::string_view instead;  // what to do with coarser voxels: "; …", may be empty
};

/// `spacing`: m along the file's own axes, instead of the file's. `nan_grey`: stands for voxels that are no number.
Scan read_scan(const ScanRequest& request, const std::optional<glm::dvec3>& spacing,
               const std::optional<double>& nan_grey, const SpacingLimits& limits);

/// Where the third axis is not perpendicular to the first two (a tilted gantry), shifts each slice within itself so
/// that it is, by cubic interpolation. The first two must be perpendicular. Returns the angle that was undone, rad.
double undo_shear(const std::filesystem::path& file, RawScan& raw);

bool is_mesh_file(const std::filesystem::path& file);

// Shared by the readers.
inline constexpr double kMostVoxels = 1.0e9;

/// Plain numbers in memory to greys.
std::vector<float> decode(const std::vector<char>& bytes, std::size_t count, Element type, bool swap);

/// An Error unless each size is at least 4 and all together at most kMostVoxels.
void check_sizes(const std::filesystem::path& file, std::string_view place, const std::vector<long long>& sizes);
std::uintmax_t size_of_file(const std::filesystem::path& file);  // Error when it cannot be read
/// All finite numbers of a text such as "1 2.5 -3"; nothing when any other thing is in it.
std::optional<std::vector<double>> parse_numbers(std::string_view text);
/// First bytes as text for a message.
std::string excerpt(std::string_view bytes);

}  // namespace typodont::haptics::importing
