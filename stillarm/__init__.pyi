from stillarm.diagnosis.notebook import Diagnosis as Diagnosis
from stillarm.diagnosis.notebook import diagnose as diagnose
