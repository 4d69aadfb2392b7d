/* Memory in pages of 2 MB where the system has them: a tree is read all over, and with pages of 4 KB most
 * reads of a large one also miss the TLB. */
#pragma once
#include <cstddef>
#include <new>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace isophote {

template <typename T>
struct HugePages {
  using value_type = T;
  static constexpr size_t PAGE = size_t(2) << 20;

  HugePages() = default;
  template <typename U>
  HugePages(const HugePages<U> &) {}

  static std::align_val_t alignment(size_t n) { return std::align_val_t(n * sizeof(T) >= PAGE ? PAGE : 64); }
  T *allocate(size_t n) {
    void *p = ::operator new(n * sizeof(T), alignment(n));
#if defined(__linux__)
    /* Only advice: where it is not taken, everything works with small pages. */
    if (n * sizeof(T) >= PAGE) madvise(p, n * sizeof(T), MADV_HUGEPAGE);
#endif
    return static_cast<T *>(p);
  }
  /* Elements are left as the memory is, so that the threads that fill them are the first to touch it. */
  template <typename U>
  void construct(U *p) noexcept { ::new (static_cast<void *>(p)) U; }
  void deallocate(T *p, size_t n) { ::operator delete(p, alignment(n)); }
  template <typename U>
  bool operator==(const HugePages<U> &) const { return true; }
};

template <typename T>
using HugeVector = std::vector<T, HugePages<T>>;

}  // namespace isophote
