// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

namespace dynfilter::odometry {

/// A vector without its oldest elements. Indices do not change when these are removed.
template <class T>
class NewestOf {
 public:
  /// Index of the oldest element.
  std::int32_t first() const { return first_; }
  /// Index after that of the newest one.
  std::size_t size() const { return static_cast<std::size_t>(first_) + items_.size(); }
  /// Number of elements that are left.
  std::size_t count() const { return items_.size(); }
  bool empty() const { return size() == 0; }

  T& operator[](std::int64_t i) { return items_[static_cast<std::size_t>(i - first_)]; }
  const T& operator[](std::int64_t i) const { return items_[static_cast<std::size_t>(i - first_)]; }
  const T& back() const { return items_.back(); }

  void push_back(T item) { items_.push_back(std::move(item)); }
  void remove_first() {
    items_.pop_front();
    ++first_;
  }

 private:
  std::deque<T> items_;
  std::int32_t first_ = 0;
};

/// A vector of which any element can be removed. Indices do not change and are not reused.
/// Elements are kept in pages, and a page is freed with its last element.
template <class T>
class SparseVector {
 public:
  /// No element has a smaller index.
  std::int64_t first() const { return kPage * first_page_; }
  /// Index after that of the newest element.
  std::size_t size() const { return size_; }
  bool has(std::int64_t i) const {
    const std::int64_t page = i / kPage - first_page_;
    return i >= 0 && page >= 0 && static_cast<std::size_t>(i) < size_ &&
           pages_[static_cast<std::size_t>(page)] && item(i).present;
  }

  /// Requires has(i).
  T& operator[](std::int64_t i) { return item(i).value; }
  const T& operator[](std::int64_t i) const { return item(i).value; }

  void push_back(T value) {
    if (size_ % kPage == 0) pages_.push_back(std::make_unique<Page>());
    Item& added = pages_.back()->items[size_++ % kPage];
    added.value = std::move(value);
    added.present = true;
  }
  /// Requires has(i).
  void remove(std::int64_t i) {
    item(i) = Item();
    std::unique_ptr<Page>& page = pages_[static_cast<std::size_t>(i / kPage - first_page_)];
    if (++page->removed == kPage) page.reset();
    for (; !pages_.empty() && !pages_.front(); ++first_page_) pages_.pop_front();
  }

 private:
  static constexpr std::int64_t kPage = 32;  // small, since one old element keeps a page
  struct Item {
    T value;
    bool present = false;
  };
  struct Page {
    std::array<Item, kPage> items;
    std::int64_t removed = 0;
  };

  Item& item(std::int64_t i) {
    return pages_[static_cast<std::size_t>(i / kPage - first_page_)]
        ->items[static_cast<std::size_t>(i % kPage)];
  }
  const Item& item(std::int64_t i) const {
    return pages_[static_cast<std::size_t>(i / kPage - first_page_)]
        ->items[static_cast<std::size_t>(i % kPage)];
  }

  std::deque<std::unique_ptr<Page>> pages_;
  std::int64_t first_page_ = 0;
  std::size_t size_ = 0;
};

}  // namespace dynfilter::odometry
