// The output of the guarded DICOM reader: plain records, which the receiver checks. They contain no name, date or
// number of a person.
#pragma once

#include <cstdint>

namespace typodont::haptics::importing {

/// Type of a record; every record begins with it.
enum class DicomRecord : std::uint32_t {
  // uint32 index of a file whose reading begins; if no record follows, the process died on this file
  kBegins = 0x44420001,
  kFile,       // DicomFile
  kFrame,      // DicomFrame, one frame of the file
  kReference,  // name of a file in a DICOMDIR, relative to it: uint32 length, then the name
  kPixels,     // DicomPixels, then the pixels' bytes
  kRefused,    // reason of a refusal in plain words: uint32 length, then the text
  kEnd,        // end of the output
};

enum class DicomKind : std::uint32_t { kOther, kImage, kNoImage, kDirectory, kColor, kUnreadable };

struct DicomFile {
  std::uint32_t number = 0;
  DicomKind kind = DicomKind::kOther;
  std::uint32_t frames = 0;
  std::uint64_t series = 0, instance = 0;  // hashes of the UIDs
  std::int32_t series_number = 0, acquisition = 0, order = 0;
  char modality[8] = {};
  std::uint32_t columns = 0, rows = 0;
  double tilt = 0;                // degrees, tilt of the gantry according to the file
  std::uint8_t derived_view = 0;  // 1: a localizer (overview image)
};

struct DicomFrame {
  std::uint8_t has_position = 0, has_orientation = 0, has_spacing = 0, has_gap = 0;
  // mm, position of the first voxel; unit vectors, directions of rows and columns; mm, spacing down and across
  double position[3] = {}, orientation[6] = {}, spacing[2] = {};
  double gap = 0;  // mm, distance between slices according to the file
  double slope = 1, intercept = 0;
};

struct DicomPixels {
  std::uint32_t number = 0;
  std::uint32_t element = 0;  // Element (scan.h)
  std::uint8_t inverted = 0;  // 1: MONOCHROME1, the smallest value is white
  std::uint8_t lossy = 0;
  std::uint64_t bytes = 0;
};

}  // namespace typodont::haptics::importing
