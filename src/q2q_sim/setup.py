"""ament_python build of q2q_sim."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "q2q_sim"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={PACKAGE: ["py.typed", "scenarios/*.yaml", "experiments/*/*.yaml", "replay_page/[!_]*/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.*")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="q2q developers",
    maintainer_email="maintainer@q2q.invalid",
    description="Simulation of vehicles, wake, radio and VICON; scenarios, flights, campaigns, reports",
    license="MIT",
    entry_points={
        "console_scripts": [
            "simulator = q2q_sim.commands.sim_nodes:simulator",
            "bag_record = q2q_sim.commands.sim_nodes:bag_record",
            "bag_play = q2q_sim.commands.sim_nodes:bag_play",
            "stack = q2q_sim.commands.sim_nodes:stack",
            "view = q2q_sim.commands.sim_nodes:view",
            "ablation = q2q_sim.commands.ablation:main",
            "bag_import = q2q_sim.commands.bag_import:main",
            "campaign = q2q_sim.commands.campaign:main",
            "crtp = q2q_sim.commands.crtp:main",
            "endurance = q2q_sim.commands.endurance:main",
            "estimators = q2q_sim.commands.estimators:main",
            "explain = q2q_sim.commands.explain:main",
            "firmware_check = q2q_sim.commands.firmware_check:main",
            "fly = q2q_sim.commands.fly:main",
            "learn_air = q2q_sim.commands.learn_air:main",
            "licence = q2q_sim.commands.licence:main",
            "policies = q2q_sim.commands.policies:main",
            "promise = q2q_sim.commands.promise:main",
            "replay_page = q2q_sim.commands.replay_page:main",
            "report = q2q_sim.commands.report:main",
            "robustness = q2q_sim.commands.robustness:main",
            "secure = q2q_sim.commands.secure:main",
            "validate = q2q_sim.commands.validate:main",
        ],
    },
)
