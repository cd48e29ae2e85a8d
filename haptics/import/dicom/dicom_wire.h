// Records that the DICOM reader's process writes; without personal data.
#pragma once

#include <cstdint>

namespace typodont::haptics::importing {

/// Type of a record. Every record begins with its type.
enum class DicomRecord : std::uint32_t {
  // uint32 index of the file. If no record follows, the process crashed on this file.
  kBegins = 0x44420001,
  kFile,       // followed by a DicomFile
  kFrame,      // followed by a DicomFrame
  kReference,  // an entry of a DICOMDIR: uint32 length, then the relative file name
  kPixels,     // followed by a DicomPixels and the bytes of the pixels
  // uint32 length, then text: why pixels cannot be read; or for headers, an attribute, a newline, its unreadable value.
  kRefused,
  kEnd,  // end of the output
};

enum class DicomKind : std::uint32_t { kOther, kImage, kNoImage, kDirectory, kColor, kUnreadable };

struct DicomFile {
  std::uint32_t number = 0;
  DicomKind kind = DicomKind::kOther;
  std::uint32_t frames = 0;
  std::uint64_t series = 0, instance = 0;  // hashes of the DICOM identifiers (UIDs) of series and image
  std::int32_t series_number = 0, acquisition = 0, phase = 0, echo = 0, order = 0;
  char modality[8] = {}, kernel[24] = {};  // kernel: name of the reconstruction filter
  std::uint32_t columns = 0, rows = 0;
  double tilt = 0;                // degrees, tilt of the gantry as the file states it
  std::uint8_t derived_view = 0;  // 1 if the image is an overview image (localizer)
};

struct DicomFrame {
  std::uint8_t has_position = 0, has_orientation = 0, has_spacing = 0, has_gap = 0, has_location = 0;
  std::uint8_t gap_is_thickness = 0;  // 1 if `gap` is only the slice thickness
  // Position of the first voxel (mm), unit vectors of rows and columns, distance between rows and columns (mm).
  double position[3] = {}, orientation[6] = {}, spacing[2] = {};
  double gap = 0;       // mm, distance between slices as the file states it
  double location = 0;  // mm, position along the stack
  double slope = 1, intercept = 0;
};

struct DicomPixels {
  std::uint32_t number = 0;
  std::uint32_t element = 0;  // value of the enumeration Element (scan_element.h)
  std::uint8_t inverted = 0;  // 1 if the smallest value is white (MONOCHROME1)
  std::uint8_t lossy = 0;
  std::uint8_t has_padding = 0;                    // 1 if some voxels lie outside the region that was measured
  double lowest_padding = 0, highest_padding = 0;  // smallest and largest stored value outside the measured region
  std::uint64_t bytes = 0;
};

}  // namespace typodont::haptics::importing
