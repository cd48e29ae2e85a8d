// What the guarded DICOM reader says about the files that it was given: plain records, checked by who reads them. No
// name, date or number of a person is among them.
#pragma once

#include <cstdint>

namespace typodont::haptics::importing {

/// Every record begins with one of these.
enum class DicomRecord : std::uint32_t {
  kBegins = 0x44420001,  // a file is looked at: uint32 its number. Where nothing follows, the process died of it
  kFile,                 // what the file is: DicomFile
  kFrame,                // one of its frames: DicomFrame
  kReference,            // of a DICOMDIR: uint32 length, the file's name relative to it
  kPixels,               // DicomPixels, then the bytes
  kRefused,              // uint32 length, why in plain words
  kEnd,                  // of everything
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
  double tilt = 0;                // degrees, of the gantry, as the file says
  std::uint8_t derived_view = 0;  // a localizer
};

struct DicomFrame {
  std::uint8_t has_position = 0, has_orientation = 0, has_spacing = 0, has_gap = 0;
  double position[3] = {}, orientation[6] = {}, spacing[2] = {};  // mm: of the first voxel; rows, columns; down, across
  double gap = 0;                                                 // mm between slices, as the file says
  double slope = 1, intercept = 0;
};

struct DicomPixels {
  std::uint32_t number = 0;
  std::uint32_t element = 0;  // Element (scan.h)
  std::uint8_t inverted = 0;  // MONOCHROME1: the least value is white
  std::uint8_t lossy = 0;
  std::uint64_t bytes = 0;
};

}  // namespace typodont::haptics::importing
