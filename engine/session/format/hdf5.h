// HDF5 for session files: handles that close themselves, and texts that state why a call failed.
#pragma once

#include <hdf5.h>

#include <string>
#include <string_view>
#include <utility>

#include "engine/session/format/columns.h"

namespace typodont::session {

/// Owns one HDF5 identifier and closes it.
class H5 {
 public:
  using Close = herr_t (*)(hid_t);
  H5() = default;
  H5(hid_t id, Close close) : id_(id), close_(close) {}
  H5(H5&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  H5& operator=(H5&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, -1);
      close_ = other.close_;
    }
    return *this;
  }
  ~H5() { reset(); }
  /// Closes the identifier. False if closing fails, for example because data could not be written.
  bool reset() noexcept {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// While this object exists, HDF5 prints no errors in this thread; see h5_reason().
class H5Quiet {
 public:
  H5Quiet();
  ~H5Quiet();
  H5Quiet(const H5Quiet&) = delete;
  H5Quiet& operator=(const H5Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Why this thread's innermost call failed. Needs an H5Quiet.
std::string h5_reason();

/// Opens an object by its path from `root`; empty if it does not exist. Accepts only what this program's writer
/// creates: hard links; data inside the file, with known filters, in one dimension, no larger than the file. Other
/// links and external data could read other files. Throws Error(`file`, path, …).
H5 open_group(const std::string& file, hid_t root, const std::string& path);
H5 open_dataset(const std::string& file, hid_t root, const std::string& path);

/// Properties for objects of a class (H5P_DATASET_CREATE, …) without time stamps: equal sessions give equal bytes.
H5 without_times(hid_t kind);
/// Creates a group; empty on failure.
H5 create_group(hid_t root, const std::string& path);

hid_t h5_type(Type type);
/// String type: UTF-8, padded with null bytes.
H5 h5_string_type(std::size_t size);

// Writing returns false on failure. Reading returns false if the attribute is missing or has another type.
bool set_attribute(hid_t object, const char* name, std::string_view text);
bool set_attribute(hid_t object, const char* name, double value);
bool set_attribute(hid_t object, const char* name, std::uint64_t value);
bool get_attribute(hid_t object, const char* name, std::string& text);
bool get_attribute(hid_t object, const char* name, double& value);
bool get_attribute(hid_t object, const char* name, std::uint64_t& value);
/// Writes text of any length as a scalar dataset, UTF-8.
bool write_text(hid_t group, const char* name, std::string_view text);
/// Reads a text that write_text() has written. `dataset`: from open_dataset().
bool read_text(const H5& dataset, std::string& text);

}  // namespace typodont::session
