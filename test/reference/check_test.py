#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What check.py finds in a header with one fault of each kind, and what it leaves alone.  check_test.py DOXYGEN"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import check

DOXYGEN = sys.argv.pop() if len(sys.argv) > 1 else "doxygen"
HEADER = """
#include <string>
/// A namespace.
namespace n {
/// A class.
class Good {
 public:
  Good();
  explicit Good(int seed);  ///< throws Error for 0
  Good(const Good&);
  ~Good();
  bool operator==(const Good& o) const;
  int size() const;
  double depth_m() const;                 ///< of the nearest
  double noise() const;                   ///< [px]
  Pose move(const Pose& T_world_camera);  ///< to the world, of the frame before
  cv::Point3f place();                    ///< in the world
 private:
  double secret_depth();
};
class Bare {
 public:
  explicit Bare(int seed);
  void silent();
  double depth();          ///< of the nearest
  cv::Point3f place();     ///< of the nearest
  void go(const Pose& x);  ///< there
};
/// Reads.
void read(double distance);
}  // namespace n
"""
BODIES = """
Good::Good(int seed) {
  if (seed == 0) throw Error("0");
}
Bare::Bare(int seed) {
  if (seed == 0) {
    throw ConfigError("0");
  }
}
inline void read(double distance) { try { f(); } catch (...) { throw ConfigError("x"); } }
inline void other() { try { throw Error("x"); } catch (...) {} }
"""


class Check(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        root = pathlib.Path(cls.folder.name)
        (root / "include/detail").mkdir(parents=True)
        (root / "plugins/detectors").mkdir(parents=True)
        (root / "include/x.hpp").write_text(HEADER)
        (root / "include/detail/x-inl.hpp").write_text(BODIES)
        (root / "Doxyfile").write_text("INPUT=include/x.hpp\nGENERATE_HTML=NO\nGENERATE_LATEX=NO\nGENERATE_XML=YES\n"
                                       "EXTRACT_ALL=YES\nEXTRACT_PRIVATE=YES\nJAVADOC_AUTOBRIEF=YES\nQUIET=YES\n")
        subprocess.run([DOXYGEN, "Doxyfile"], cwd=root, check=True, stderr=subprocess.DEVNULL)
        cls.classes, cls.members = check.read(root / "xml")
        cls.thrown = check.throwing(root)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def names(self, faults):
        return sorted(fault.split(": ")[1].replace("n::", "") for fault in faults)

    def test_comments_are_missed(self):
        faults = check.undescribed(self.classes, self.members)
        self.assertEqual(self.names(faults), ["Bare", "Bare::Bare", "Bare::silent"])

    def test_units_are_missed(self):
        faults = check.without_unit(self.classes, self.members)
        self.assertEqual(self.names(faults), ["Bare::depth", "read"])

    def test_frames_of_reference_are_missed(self):
        faults = check.without_frame(self.classes, self.members)
        self.assertEqual(self.names(faults), ["Bare::go", "Bare::place"])

    def test_errors_are_missed(self):
        self.assertEqual(self.thrown, {("x", "Good", "Good"), ("x", "Bare", "Bare"), ("x", "", "read")})
        faults = check.without_errors(self.classes, self.members, self.thrown)
        self.assertEqual(self.names(faults), ["Bare::Bare", "read"])

    def test_folders_rooms_and_cards_are_missed(self):
        root = pathlib.Path(self.folder.name)
        (root / "include/dynfilter/core").mkdir(parents=True)
        (root / "docs/reference/filters").mkdir(parents=True)
        (root / "docs/reference/filters/gms.md").write_text("# gms")
        (root / "html").mkdir()
        (root / "html/group__core.html").write_text("")
        (root / "html/group__detectors.html").write_text("Classes</h2> " + str(root))
        faults = sorted(fault.split(":")[0] for fault in check.wrong_pages(root, str(root)))
        self.assertEqual(faults, ["gms.md", "group__core.html", "group__detectors.html"])


if __name__ == "__main__":
    unittest.main()
