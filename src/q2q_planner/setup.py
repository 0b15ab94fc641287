"""ament_python build of q2q_planner."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "q2q_planner"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="q2q developers",
    maintainer_email="maintainer@q2q.invalid",
    description="Trajectory planning: minimum snap, avoidance of interaction zones, online replanner",
    license="MIT",
    entry_points={
        "console_scripts": [
            "trajectory = q2q_planner.commands.planner_nodes:trajectory",
            "replanner = q2q_planner.commands.planner_nodes:replanner",
            "plan = q2q_planner.commands.plan:main",
        ],
    },
)
