// Included once in each namespace of lane_ops.h. Changes samples and sums the removed volume of each tissue.

/// Returns `depth` in lanes where `ahead` is set and `depth` exceeds both `old` and −kMargin (−3.5 voxels); otherwise
/// `old`. Sets `least` to the larger of `old` and −kMargin, and `rises` to the mask of the lanes with `depth`.
TYPODONT_INLINE Floats raised_to(Floats old, Floats depth, Mask ahead, Floats& least, Mask& rises) {
  least = greater(old, all(-Sweep::kMargin));
  rises = more_where(ahead, depth, least);
  return pick(rises, depth, old);
}

/// Removed fraction of each voxel when its sample changes from `was` to `is`, in the units of inside_fraction.h.
TYPODONT_INLINE Ints share_taken(Floats was, Floats is) {
  const Floats before = greater(was, all(-0.5f)), after = greater(lesser(is, all(0.5f)), before);
  return (Ints)(after + all(1.5f)) - (Ints)(before + all(1.5f));
}

typedef std::uint8_t Bytes __attribute__((vector_size(kLanes), aligned(1), may_alias));
/// Hardness bytes of samples (label.h, dense_tissue.h); filled samples have the filling's hardness. `labels` null:
/// nothing is filled.
TYPODONT_INLINE Ints felt_hardness(const Tissue* labels, const std::uint8_t* hardness) {
  Bytes bytes = *reinterpret_cast<const Bytes*>(hardness);
  if (labels) bytes |= (Bytes)(*reinterpret_cast<const Bytes*>(labels) > kShown);
  return __builtin_convertvector(bytes, Ints);
}

/// Sums removed volume. While the label stays the same, one running sum is used.
struct Taken {
  RemovedVolume* removed;
  GradedSamples graded;  // a copy, so that its pointers stay in registers
  Ints units = {};
  // Sum of (removed volume × hardness byte), in two numbers: the low 16 bits, and the higher bits.
  Ints hard_low = {}, hard_high = {};
  int groups = 0;
  std::uint8_t label = 0;

  /// `to` may be null if add() is never called.
  TYPODONT_INLINE Taken(RemovedVolume* to) : removed(to) {
    if (to) graded = to->graded;
  }

  /// Adds a group in which all samples have one label.
  TYPODONT_INLINE void add(Ints taken, std::uint8_t group_label, const float* samples) {
    change_label(group_label);
    units += taken;
    if (graded.hardness && any_positive(taken)) {
      const std::ptrdiff_t at = samples - graded.distance;
      const Tissue* const labels = graded.tissue ? graded.tissue + at : nullptr;
      const Ints weighted = taken * felt_hardness(labels, graded.hardness + at);
      hard_low += weighted & 0xffff;
      hard_high += weighted >> 16;
    }
    if (++groups == 255) close();  // each addend is at most 2^23 units, so 255 groups stay below 2^31
  }
  /// Adds the samples `from` to `to` with any labels. `labels`: label of the group's first sample.
  TYPODONT_INLINE void add(Ints taken, const Tissue* labels, const float* samples, int from, int to) {
    if (from == 0 && to == kLanes) {
      std::uint64_t parts[kLanes / 8], differ = 0;
      std::memcpy(parts, labels, sizeof parts);
      for (std::uint64_t& part : parts) part &= kShown * 0x0101010101010101u;
      for (const std::uint64_t part : parts) differ |= part ^ (parts[0] & 0xff) * 0x0101010101010101u;
      if (!differ) {
        add(taken, static_cast<std::uint8_t>(parts[0]), samples);
        return;
      }
    }
    std::int32_t apart[kLanes];
    std::memcpy(apart, &taken, sizeof apart);
    for (int i = from; i < to; ++i) removed->add(apart[i], shown(labels[i]), samples + i);
  }
  TYPODONT_INLINE void close() {
    removed->volume[label] += kFractionUnit * static_cast<double>(sum_of_lanes(units));
    if (graded.hardness) removed->hardened[label] += (sum_of_lanes(hard_high) << 16) + sum_of_lanes(hard_low);
    units = hard_low = hard_high = Ints{};
    groups = 0;
  }

 private:
  TYPODONT_INLINE void change_label(std::uint8_t group_label) {
    if (group_label == label) return;
    close();
    label = group_label;
  }
  TYPODONT_INLINE static std::int64_t sum_of_lanes(const Ints& v) {
    std::int32_t apart[kLanes];  // separate array, so that the sums stay in a register
    std::memcpy(apart, &v, sizeof apart);
    std::int64_t sum = 0;
    for (const std::int32_t part : apart) sum += part;
    return sum;
  }
};
