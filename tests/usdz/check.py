"""Prints what Apple's rules, of USD's former checker, say of a file; has a Python of its own."""

import json
import sys

from pxr import UsdUtils

checker = UsdUtils.ComplianceChecker(arkit=True)
checker.CheckCompliance(sys.argv[1])
found = [*checker.GetErrors(), *checker.GetFailedChecks(), *checker.GetWarnings()]
print(json.dumps(found))
