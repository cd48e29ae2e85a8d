// The program's side of the guarded DICOM reader.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "haptics/import/dicom/dicom_wire.h"

namespace typodont::haptics::importing {

struct DicomHeader {
  DicomFile file;
  std::vector<DicomFrame> frames;
  std::vector<std::string> references;  // of a DICOMDIR
};

/// What each of the files is. A file that the reader dies of is unreadable; the others are read all the same.
std::vector<DicomHeader> read_dicom_headers(std::span<const std::filesystem::path> files);

/// The decoded pixels of each file, one after the other. `largest`, `total`: bytes of the largest and of all of them,
/// as the headers promise. Throws Error, with `name` for its file, where one cannot be decoded.
void read_dicom_pixels(const std::string& name, std::span<const std::filesystem::path> files, std::uint64_t largest,
                       std::uint64_t total,
                       const std::function<void(const DicomPixels& pixels, std::vector<char>& bytes)>& take);

}  // namespace typodont::haptics::importing
