"""ament_python build of q2q."""

from setuptools import find_packages, setup

PACKAGE = "q2q"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="q2q developers",
    maintainer_email="maintainer@q2q.invalid",
    description="Simulated flights, plans, models and campaigns in Python, without ROS",
    license="MIT",
)
