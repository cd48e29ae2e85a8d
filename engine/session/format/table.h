// HDF5 datasets that grow, or are overwritten, during a recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/format/hdf5.h"

namespace typodont::session {

/// A table whose rows have a fixed size; each column is a dataset. HDF5 compresses and writes it in chunks. A flush may
/// write an incomplete chunk, which is written again when it is complete.
class Table {
 public:
  struct Spec {
    std::string name, unit, text, labels;
    H5 type;
    std::size_t size;
  };

  bool create(hid_t file, const std::string& path, const std::string& text, std::vector<Spec> specs, std::size_t chunk,
              int deflate);

  std::byte* cell(std::size_t column) { return columns_[column].buffer.data() + columns_[column].size * buffered_; }
  template <class T>
  void put(std::size_t column, const T& value) {
    std::memcpy(cell(column), &value, sizeof value);
  }
  /// Stores a text of at most the column's size.
  void put(std::size_t column, std::string_view text) {
    std::memset(cell(column), 0, columns_[column].size);
    std::memcpy(cell(column), text.data(), text.size());
  }
  void end_row() { ++buffered_; }
  std::size_t buffered() const { return buffered_; }
  std::uint64_t written() const { return written_; }
  /// True if the buffered rows complete a chunk, so that they should be written.
  bool full() const { return buffered_ > 0 && (written_ + buffered_) % chunk_ == 0; }
  void drop() { buffered_ = 0; }

  bool write();
  /// Number of rows since the last commit(). A power cut would lose them.
  std::uint64_t uncommitted() const { return written_ - committed_; }
  void commit() { committed_ = written_; }
  void close() { columns_.clear(); }

 private:
  struct Data {
    H5 dataset, type;
    std::size_t size;
    std::vector<std::byte> buffer;
  };
  std::vector<Data> columns_;
  std::size_t chunk_ = 1, buffered_ = 0;
  hsize_t written_ = 0, committed_ = 0;
};

/// Creates a scalar or one-dimensional dataset, whose values overwrite() replaces later.
bool create_numbers(hid_t parent, const char* name, const char* unit, const char* text, hid_t type, hsize_t count,
                    const void* initial, H5& dataset, const std::string& labels = "");
bool overwrite(const H5& dataset, hid_t type, const void* value);

}  // namespace typodont::session
